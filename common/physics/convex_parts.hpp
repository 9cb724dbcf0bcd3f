// Several convex hulls for one solid, so that its openings stay open: an approximate convex decomposition. The solid is cut
// at its notches, one plane at a time. Several planes are tried, and the one whose parts have the smallest hulls is used.
// Parts whose common hull is hardly larger are merged again.
// Lien & Amato 2007, "Approximate convex decomposition of polyhedra", divide at the deepest notch until parts are convex
// enough. Wei, Liu, Ling & Su 2022, "Approximate convex decomposition for 3D meshes with collision-aware concavity and tree
// search", cut the mesh itself by planes that they try, and merge. Mamou & Ghorbel 2009, "A simple and efficient approach
// for 3D mesh approximate convex decomposition", merge greedily. DECISION.md, "Hulls that keep openings", says how this
// differs from them, and why.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/physics/collision_hulls.hpp"

namespace fracture {

struct ConvexParts {
  /// 1 to HullLimits::count hulls, not inset; none if the solid is flat (ConvexHullBuilder::build()). Together they cover the
  /// solid, except for corners that each hull may leave out (kHullTolerance).
  std::vector<CollisionHull> hulls;
  std::uint32_t simplified = 0;  ///< number of hulls that had more than kMaxHullPoints extreme points
  double volume = 0;             ///< of the solid with closed cavities filled; in the points' unit cubed
  /// Sum of the hulls' volumes over `volume`: an upper bound for their union. May be slightly below 1,
  /// because hulls may leave corners out (kHullTolerance).
  double excess = 0;
  /// The largest ratio of a hull's volume to the volume of its part. At most HullLimits::excess, unless HullLimits::count
  /// is reached or a part has no notches.
  double largest_excess = 0;
};

/// Divides a solid. `points` must be finite. `triangles` are counter-clockwise from outside, and each edge is used equally
/// often in both directions. A closed cavity counts as solid, because nothing can fly into it. Results are in the frame and
/// unit of the points, and the same with every compiler. Takes about 1.5 µs per triangle and hull, more on round solids.
/// Throws Interrupted.
ConvexParts make_convex_parts(std::span<const Vec3f> points,
                              std::span<const std::array<std::uint32_t, 3>> triangles,
                              const HullLimits& limits, const Execution& execution);

}  // namespace fracture
