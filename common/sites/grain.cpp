#include "common/sites/grain.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "common/base/long_axis.hpp"
#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/moments.hpp"

namespace fracture {
namespace {

using sites_detail::Moments;

constexpr double kSameDirection = 0.985;  // cosine of ten degrees
/// Ratio of second moments along the longest axis and the next: that of a bar half as long again as it is wide.
constexpr double kLeastElongation = 2.25;

/// The axis along which it is longest, if it is much longer there.
std::optional<Vec3d> axis_of(const Moments& moments) {
  if (!(moments.volume > 0)) return std::nullopt;
  const std::optional<LongAxis> longest = long_axis(moments.central());
  if (!longest || !(longest->ratio > kLeastElongation)) return std::nullopt;
  return sites_detail::without_noise(longest->axis);
}

}  // namespace

Grains grains_of(const Solid& solid, bool by_node, const Vec3d& whole, std::size_t most,
                 const Execution& execution) {
  const std::size_t parts = solid.parts.size();
  std::vector<std::uint32_t> group(parts);
  std::uint32_t groups = 0;
  Pacer pacer(execution);
  pacer.each(0, parts, [&](std::size_t p) {
    group[p] = by_node ? solid.parts[p].node : static_cast<std::uint32_t>(p);
    groups = std::max(groups, group[p] + 1);
  });
  // About the middle of a part's box, or of the solid's: near enough that little is lost to rounding.
  std::vector<Moments> moments;
  resize_with_polls(execution, moments, groups);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(8);
    const std::uint32_t p = solid.part[t];
    const Vec3d origin = by_node ? solid.box.center() : solid.parts[p].box.center();
    const auto& [a, b, c] = solid.triangles[t];
    moments[group[p]].add(to_double(solid.positions[a]) - origin, to_double(solid.positions[b]) - origin,
                          to_double(solid.positions[c]) - origin);
  }

  std::vector<std::uint32_t> order(groups);
  std::iota(order.begin(), order.end(), 0u);
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
    return moments[x].volume != moments[y].volume ? moments[x].volume > moments[y].volume : x < y;
  });
  Grains grains;
  std::vector<std::uint8_t> of_group(groups, 0);
  for (const std::uint32_t g : order) {
    if (!(moments[g].volume > 0) && !grains.directions.empty()) break;  // nothing of that number, or as good
    pacer.step(16);
    const Vec3d direction = axis_of(moments[g]).value_or(whole);
    const auto cosine = [&](const Vec3d& other) { return std::fabs(dot(direction, other)); };
    const auto nearest =
        std::max_element(grains.directions.begin(), grains.directions.end(),
                         [&](const Vec3d& x, const Vec3d& y) { return cosine(x) < cosine(y); });
    if (nearest != grains.directions.end() &&
        (cosine(*nearest) > kSameDirection || grains.directions.size() >= most)) {
      of_group[g] = static_cast<std::uint8_t>(nearest - grains.directions.begin());
      continue;
    }
    of_group[g] = static_cast<std::uint8_t>(grains.directions.size());
    grains.directions.push_back(direction);
  }
  if (grains.directions.empty()) grains.directions.push_back(whole);
  grains.of_part.resize(parts);
  pacer.each(0, parts, [&](std::size_t p) { grains.of_part[p] = of_group[group[p]]; });
  return grains;
}

}  // namespace fracture
