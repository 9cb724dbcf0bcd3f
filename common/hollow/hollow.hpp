// Makes parts of a solid hollow, for objects that are hollow although their mesh is solid.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "common/base/execution.hpp"
#include "common/mesh/part_selector.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Minimum number of triangles for which an inner side is worthwhile.
inline constexpr std::uint32_t kLeastTriangles = 500;
/// Smaller balls are not searched for, because that needs a lattice with a step of a fourth of their
/// diameter.
inline constexpr double kSmallestBall = 0.1;

/// The walls of the parts that a selector matches. The members are as in HollowOptions.
struct PartWalls {
  PartSelector selector{};
  double thickness = 0, fraction = 0, least_ball = 0;
  bool any() const { return thickness > 0 || fraction > 0; }
  friend bool operator==(const PartWalls&, const PartWalls&) = default;
};

struct HollowOptions {
  double thickness = 0;  ///< thickness of the walls, m; 0: determined by `fraction`
  double fraction = 0;   ///< thickness / longest side of the part's box; both 0: nothing becomes hollow
  double least_ball =
      0;  ///< diameter / longest side. Only parts that can contain such a ball become walls. 0: all parts
          ///< that are thick enough. Otherwise at least kSmallestBall, and inner sides have fewer
          ///< triangles: the maximum is the largest of 1000, 4 · the triangles of the outside, and 4000 ·
          ///< (longest side of the part / longest side of any such part)²
  std::uint32_t max_triangles = 20'000;  ///< maximum for the inner side of one part
  std::uint32_t max_all =
      400'000;  ///< maximum for all parts; parts with fewer than kLeastTriangles left stay solid
  /// Parts that have other walls, or none. If several entries match a part, the first one decides.
  std::vector<PartWalls> by_part{};
  bool any() const {
    return thickness > 0 || fraction > 0 ||
           std::any_of(by_part.begin(), by_part.end(), [](const PartWalls& walls) { return walls.any(); });
  }
  friend bool operator==(const HollowOptions&, const HollowOptions&) = default;
};

/// Returns the solid with a cavity in each part that has none and is thick enough (hollow/inner_surface.hpp).
/// Cavities are additional shells of the part, with kCavityMaterial. Their wedges are added to a copy of the
/// source. A part, or a region of it, that is thinner than twice the thickness is unchanged. The report
/// describes the changes. Throws Interrupted, as choose_parts() does.
Solid hollowed(Solid solid, const HollowOptions& options, const Execution& execution);

}  // namespace fracture
