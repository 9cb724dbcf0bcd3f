#include "common/sites/part_shares.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/bvh/ray_crossing.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/sites/generators.hpp"
#include "common/sites/request_places.hpp"

namespace fracture {
namespace {

/// Distance at which a part weighs half as much as the part that is hit / radius of the impact.
constexpr double kHalf = 0.125;
/// Share of the pieces near the hit, for patterns without a parameter for it.
constexpr double kShareNear = 0.8;

/// The distance of each part to a point, m, or infinity beyond `reach`; 0 if the point is inside the part.
std::vector<double> distances(const Solid& solid, const Vec3d& point, double reach, Pacer& pacer) {
  const std::size_t parts = solid.parts.size();
  std::vector<double> distance(parts, HUGE_VAL), to_box(parts);
  std::vector<int> winding(parts, 0);
  for (std::size_t p = 0; p < parts; ++p) {
    pacer.step();
    to_box[p] = std::sqrt(square_distance(solid.parts[p].box, point));
  }
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const std::uint32_t p = solid.part[t];
    pacer.step(to_box[p] <= reach ? 4 : 1);
    if (to_box[p] > reach) continue;
    const auto& [a, b, c] = solid.triangles[t];
    const std::array<Vec3d, 3> corners{to_double(solid.positions[a]), to_double(solid.positions[b]),
                                       to_double(solid.positions[c])};
    if (to_box[p] == 0)
      winding[p] += ray_crossing(corners[0] - point, corners[1] - point, corners[2] - point);
    if (square_distance(box_of(corners), point) < distance[p] * distance[p])
      distance[p] = std::fmin(distance[p], distance_to_triangle(point, corners[0], corners[1], corners[2]));
  }
  for (std::size_t p = 0; p < parts; ++p) {
    if (winding[p] != 0) distance[p] = 0;
    if (distance[p] > reach) distance[p] = HUGE_VAL;
  }
  return distance;
}

}  // namespace

std::optional<PartShares> shares_of_parts(const Solid& solid, const SitePattern& pattern,
                                          const Execution& execution) {
  const std::span<const Vec3d> impacts = impacts_of(pattern);
  if (impacts.empty() || solid.parts.size() < 2) return std::nullopt;
  double radius = solid.box.longest_side() / 3, share_near = kShareNear;
  if (const auto* impact = std::get_if<ImpactPattern>(&pattern)) {
    if (!impact->by_parts) return std::nullopt;
    radius = impact->radius.value_or(radius);
    share_near = impact->share;
  } else if (const auto* radial = std::get_if<RadialPattern>(&pattern);
             !radial || !sites_detail::breaks_by_parts(*radial)) {
    return std::nullopt;
  }
  PartShares shares;
  const std::size_t parts = solid.parts.size();
  shares.near.assign(parts, 0);
  Pacer pacer(execution);
  double near = 0, volume = 0;
  for (const Vec3d& impact : impacts) {
    const std::vector<double> distance = distances(solid, impact, radius, pacer);
    for (std::size_t p = 0; p < parts; ++p) {
      if (distance[p] == HUGE_VAL) continue;
      const double far = distance[p] / (kHalf * radius), weight = 1 / (1 + far * far);
      shares.near[p] += weight;
      near += weight;
    }
  }
  if (!(near > 0)) return std::nullopt;
  for (const Part& part : solid.parts) volume += part.volume;
  for (std::size_t p = 0; p < parts; ++p) {
    shares.near[p] /= near;
    shares.share.push_back(share_near * shares.near[p] + (1 - share_near) * solid.parts[p].volume / volume);
    if (shares.near[p] > shares.near[shares.nearest]) shares.nearest = static_cast<std::uint32_t>(p);
  }
  return shares;
}

namespace sites_detail {

bool breaks_by_parts(const RadialPattern& pattern) {
  return pattern.around == RadialPattern::Around::kShape && !pattern.axis && !pattern.spokes &&
         !pattern.rings;
}

ShapesForPieces shapes_for(const Solid& solid, const RadialPattern& pattern, const Execution& execution) {
  ShapesForPieces made{shares_of_parts(solid, pattern, execution), {}};
  const std::span<const double> sizes =
      made.shares ? std::span<const double>(made.shares->share) : std::span<const double>();
  made.shapes = shapes_of(solid, CellMap::kMostFrames, execution, sizes);
  return made;
}

}  // namespace sites_detail
}  // namespace fracture
