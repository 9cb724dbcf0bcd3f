// Convex collision hulls, which a physics engine collides instead of the visible mesh. The part of a fragment
// in one cell lies in that convex cell, and so does its hull. Therefore hulls of neighbours cannot overlap.
// They are also shrunk towards their centres, so they do not even touch: a solver pushes touching hulls
// apart at spawn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Maximum number of points. Most engines limit convex hulls to 255 or 256.
inline constexpr std::uint32_t kMaxHullPoints = 255;
/// Corners that stick out of a hull by less may be left out. Relative to about half of the body's least width (DECISION.md).
inline constexpr double kHullTolerance = 0.01;
/// m: the approximate distance that a hull's faces are moved inwards (at least half of it, more on round hulls). It is
/// absolute, because the tolerances of engines are. Without it, Rapier's GJK reports overlaps of some splinters
/// (DECISION.md).
inline constexpr double kHullInset = 4e-4;
/// Each hull is scaled about its centre by 1 - shrink. The first two bounds limit the shrink for the inset: a large hull is
/// moved by more than the rounding of its coordinates, and a splinter keeps its shape. Far from the origin, a step of the
/// seam lattice exceeds the inset. Hulls there are shrunk by the step instead, up to the last bound.
inline constexpr double kLeastHullShrink = 0.001, kMostHullShrink = 0.25, kMostRoundedShrink = 0.75;

/// A convex hull for physics engines, in the fragment's local frame.
struct CollisionHull {
  std::vector<Vec3f> points;                            ///< at most 255
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise from outside
  double untrimmed = 0;  ///< m³: its volume before it was trimmed (hull_trim.hpp, rest.hpp); 0: it was not
};

/// The hulls of one fragment.
struct FragmentHulls {
  std::vector<CollisionHull> hulls;  ///< one for each body (member cell), or fewer (aggregate_hulls.hpp)
  std::uint32_t flat = 0;  ///< bodies too thin for a hull (1e-5 of their extent), which get a small cube
  std::uint32_t simplified = 0;  ///< hulls without some extreme points, because of kMaxHullPoints
  double volume = 0;             ///< m³: sum of the hulls before they are shrunk
  /// `volume` relative to the fragment's, with closed cavities filled if it was divided; 0 if the fragment has no volume.
  double excess = 0;
  /// For hull_trim.hpp: whether the hulls have been compared with contacts and trimmed if necessary.
  bool seen_contacts = false;
  bool shared =
      false;  ///< hulls of an instance's shape (pipeline/instanced_bodies.hpp), which are not divided again
};

struct HullReport {
  std::uint32_t hulls = 0, flat = 0, simplified = 0;  ///< sums of FragmentHulls
  double excess = 0;                                  ///< the largest one of a fragment; 0 without hulls
  bool operator==(const HullReport&) const = default;
};

/// A companion of a FragmentSet.
struct CollisionHulls {
  std::vector<FragmentHulls> of_fragment;  ///< one for each; empty if none were requested

  std::span<const CollisionHull> of(std::size_t fragment) const {
    if (of_fragment.empty()) return {};
    return of_fragment[fragment].hulls;
  }
  HullReport report() const;
};

inline constexpr std::uint32_t kMostHulls = 64;  ///< maximum of HullLimits::count

/// Limits that decide how many hulls a fragment gets.
struct HullLimits {
  /// A fragment whose hulls have more than this many times its volume is divided (divided_hulls.hpp). At least 1; near 1, a
  /// bent fragment gets the maximum number of hulls.
  double excess = 1.5;
  std::uint32_t count = 4;  ///< at least 1
};

/// Makes the hulls of all fragments with a shape, in their local frames. Hulls in `known`, which may be empty, are kept, and those that are shared are not changed;
/// other fragments get one hull for each body. If these exceed `limits.excess`, the fragment gets as many as its openings
/// need, at most `limits.count`. The set's lattice step tells how far corners were rounded. Throws Interrupted.
CollisionHulls make_collision_hulls(const FragmentSet& set, CollisionHulls known, const HullLimits& limits,
                                    const Execution& execution);

}  // namespace fracture
