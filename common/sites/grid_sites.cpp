// Product grids: every combination of three lists of coordinates is a site. The cells are exact boxes,
// because the nearest site is found axis by axis. Jitter moves whole planes of sites, so joints stay plane.
#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/sites/division.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kGridStream = 0x6a1d'0000'0000'0001ull;

/// Returns the scale at which about `wanted` boxes of this shape fill the box of the solid: the largest scale
/// that gives at least that many.
double scale_for(const Vec3d& side, const Vec3d& shape, double wanted) {
  const auto count = [&](double scale) {
    double n = 1;
    for (int a = 0; a < 3; ++a) n *= whole(side[a] / (scale * shape[a]));
    return n;
  };
  double high = 1;
  for (int a = 0; a < 3; ++a) high = std::fmax(high, 2 * side[a] / shape[a]);
  double low = high;
  while (count(low) < wanted && low > high * 1e-9) low /= 2;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (low + high);
    (count(middle) >= wanted ? low : high) = middle;
  }
  return low;
}

/// Number of boxes that the solid's bounding box needs so that the solid itself gets the requested number.
double wanted_in_box(const Task& task) {
  const Vec3d side = task.solid.box.size();
  const double box = side.x * side.y * side.z, volume = task.solid.report.volume;
  return volume > 0 && box > volume ? task.count * std::fmin(box / volume, 64) : task.count;
}

}  // namespace

double expected_sites(const GridPattern& pattern, double count, const Vec3d& sides) {
  return pattern.cell ? boxes_in(sides, *pattern.cell) : count;
}

Expected<SitePlan> generate(const Task& task, const GridPattern& pattern, const ImageMap&) {
  const Box& box = task.solid.box;
  std::array<Division, 3> d;
  const double scale = pattern.cell ? 0 : scale_for(box.size(), {1, 1, 1}, wanted_in_box(task));
  for (int a = 0; a < 3; ++a)
    d[a] = pattern.cell ? covering(box.min[a], box.max[a], (*pattern.cell)[a])
                        : fitted(box.min[a], box.max[a], scale);
  if (product(d) > task.most_sites)
    return pattern.cell ? too_many_sites(task, product(d), "grid", "cell", "a larger")
                        : too_many_sites(task, product(d), "grid");
  Random random(task.seed ^ kGridStream);
  std::array<std::vector<double>, 3> at;
  for (int a = 0; a < 3; ++a) at[a] = coordinates(d[a], pattern.jitter, random);
  Pacer pacer(task.execution);
  SitePlan plan;
  for (const double z : at[2])
    for (const double y : at[1])
      for (const double x : at[0]) {
        pacer.step();
        plan.points.push_back({x, y, z});
      }
  return plan;
}

}  // namespace fracture::sites_detail
