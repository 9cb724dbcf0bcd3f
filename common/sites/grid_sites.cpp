// Product grids: three lists of coordinates, every combination a site. The cells are boxes, exactly: the
// nearest site is found axis by axis. Whole planes of sites jitter, so joints stay plane.
#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kGridStream = 0x6a1d'0000'0000'0001ull;

/// Along one axis: `count` cells of the same size, in the middle of [min, max].
struct Division {
  double start, step;
  std::uint32_t count;
};

double whole(double x) { return std::fmax(1, std::nearbyint(x)); }

/// As many cells of about `size` as fill the side.
Division fitted(double min, double max, double size) {
  const double n = size > 0 ? whole((max - min) / size) : 1;
  return {min, (max - min) / n, static_cast<std::uint32_t>(n)};
}

/// Cells of exactly this size that cover the side. A rest of less than a thousandth of a cell (rounding, say)
/// belongs to its neighbour.
Division covering(double min, double max, double size) {
  const double n = std::fmax(1, std::ceil((max - min) / size - 1e-3));
  return {0.5 * (min + max) - 0.5 * n * size, size,
          static_cast<std::uint32_t>(std::fmin(n, 2.0 * kMaxPatternSites))};
}

/// The scale at which boxes of this shape fill the box of the solid with about `wanted` of them: the largest
/// one that makes at least as many.
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

/// How many boxes the whole box of the solid needs so that the solid gets as many as asked.
double wanted_in_box(const Task& task) {
  const Vec3d side = task.solid.box.size();
  const double box = side.x * side.y * side.z, volume = task.solid.report.volume;
  return volume > 0 && box > volume ? task.count * std::fmin(box / volume, 64) : task.count;
}

/// The coordinates of the sites along one axis: in the middles of the cells, moved by up to half the jitter.
std::vector<double> coordinates(const Division& d, double jitter, Random& random) {
  std::vector<double> at;
  for (std::uint32_t k = 0; k < d.count; ++k)
    at.push_back(d.start + (k + 0.5 + jitter * (random.uniform() - 0.5)) * d.step);
  return at;
}

double product(const std::array<Division, 3>& d) {
  return static_cast<double>(d[0].count) * d[1].count * d[2].count;
}

/// A brick is as many cells as the shift of a course divides it into.
std::uint32_t cells_of_brick(BrickPattern::Bond bond) {
  return bond == BrickPattern::Bond::kStack ? 1 : bond == BrickPattern::Bond::kHalf ? 2 : 3;
}

}  // namespace

double expected_sites(const GridPattern& pattern, double count, const Vec3d& sides) {
  return pattern.cell ? boxes_in(sides, *pattern.cell) : count;
}

double expected_sites(const BrickPattern& pattern, double count, const Vec3d& sides) {
  return cells_of_brick(pattern.bond) * (pattern.cell ? boxes_in(sides, *pattern.cell) : count);
}

Expected<SitePlan> generate(const Task& task, const GridPattern& pattern, const ImageMap&) {
  const Box& box = task.solid.box;
  std::array<Division, 3> d;
  const double scale = pattern.cell ? 0 : scale_for(box.size(), {1, 1, 1}, wanted_in_box(task));
  for (int a = 0; a < 3; ++a)
    d[a] = pattern.cell ? covering(box.min[a], box.max[a], (*pattern.cell)[a])
                        : fitted(box.min[a], box.max[a], scale);
  if (product(d) > task.most_sites) return too_many_sites(task, product(d));
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

Expected<SitePlan> generate(const Task& task, const BrickPattern& pattern, const ImageMap&) {
  const Box& box = task.solid.box;
  const Vec3d size = box.size();
  const int along = size.x >= size.z ? 0 : 2, deep = 2 - along;  // the wall runs along its longer side
  constexpr int up = 1;
  // 225 x 75 x 112.5 mm: the coordinating size of the European standard brick, its joint included.
  Vec3d shape;
  shape[along] = 3;
  shape[up] = 1;
  shape[deep] = 1.5;
  std::array<Division, 3> d;
  if (pattern.cell) {
    const Vec3d cell = *pattern.cell;
    const double lengths[3] = {cell.x, cell.y, cell.z};
    d[along] = covering(box.min[along], box.max[along], lengths[0]);
    d[up] = covering(box.min[up], box.max[up], lengths[1]);
    d[deep] = covering(box.min[deep], box.max[deep], lengths[2]);
  } else {
    const double scale = scale_for(size, shape, wanted_in_box(task));
    for (int a = 0; a < 3; ++a) d[a] = fitted(box.min[a], box.max[a], scale * shape[a]);
  }
  const std::uint32_t split = cells_of_brick(pattern.bond);
  const std::uint32_t bricks = d[along].count + 1;  // in a course, the cut one at its end included
  d[along].count *= split;
  d[along].step /= split;
  if (product(d) > task.most_sites) return too_many_sites(task, product(d));
  Random random(task.seed ^ kGridStream);
  std::array<std::vector<double>, 3> at;
  for (const int a : {along, up, deep}) at[a] = coordinates(d[a], pattern.jitter, random);
  Pacer pacer(task.execution);
  SitePlan plan;
  for (std::uint32_t w = 0; w < d[deep].count; ++w)
    for (std::uint32_t row = 0; row < d[up].count; ++row)
      for (std::uint32_t k = 0; k < d[along].count; ++k) {
        pacer.step();
        Vec3d p;
        p[along] = at[along][k];
        p[up] = at[up][row];
        p[deep] = at[deep][w];
        plan.points.push_back(p);
        plan.groups.push_back((w * d[up].count + row) * bricks + (k + (row + w) % split) / split);
      }
  return plan;
}

}  // namespace fracture::sites_detail
