// Things that are hollow although their mesh is not: parts of a solid become walls.
#pragma once

#include <memory>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Fewer make no hollow worth the name.
inline constexpr std::uint32_t kLeastTriangles = 500;
/// Smaller balls are not looked for: it takes a lattice of a fourth of their diameter.
inline constexpr double kSmallestBall = 0.1;

struct HollowOptions {
  double thickness = 0;  ///< metres, of the walls; 0: as `fraction` says
  double fraction = 0;   ///< of the longest side of a part's box; 0 with thickness 0: nothing becomes hollow
  double least_ball =
      0;  ///< diameter, as a fraction of that side: only what holds such a ball becomes walls; 0: whatever is
  ///< thick enough; else at least kSmallestBall. With it the inner side of a part has at most four times
  ///< as many triangles as its outside, or 4000, of parts that are smaller than others down to 1000
  std::uint32_t max_triangles = 20'000;  ///< of the inner side of one part
  std::uint32_t max_all =
      400'000;  ///< of all: parts for which fewer than kLeastTriangles are left stay solid
  bool any() const { return thickness > 0 || fraction > 0; }
  friend bool operator==(const HollowOptions&, const HollowOptions&) = default;
};

/// The solid with a cavity in each part that has none and is thick enough (hollow/inner_surface.hpp): further
/// shells of the part, of kCavityMaterial, whose wedges are added to a copy of the source. A part, or a place of it,
/// that is thinner than twice the thickness stays as it is. The report says what was done. Throws Interrupted.
Solid hollowed(Solid solid, const HollowOptions& options, const Execution& execution);

}  // namespace fracture
