// Convex collision hulls: what a physics engine collides instead of the visible mesh. The part of a fragment
// in one cell lies in that convex cell, hence so does its hull, and hulls of neighbours cannot overlap;
// shrunk towards their centres they do not even touch (hulls that touch exactly are pushed apart by the
// solver at spawn).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Most engines cap convex hulls at 255 or 256 points.
inline constexpr std::uint32_t kMaxHullPoints = 255;
/// What sticks out of a hull by less, of half of its body's least width or some more, is left out (DECISION.md).
inline constexpr double kHullTolerance = 0.01;
/// m: how far a hull's faces are moved inwards, about (at least half of it, more on round hulls). In metres,
/// because the tolerances of the engines are: with none, Rapier's GJK takes some splinters for overlapping
/// (DECISION.md).
inline constexpr double kHullInset = 4e-4;
/// Each hull is scaled about its centre by 1 - shrink; the inset is bounded by these, so that a large hull is
/// inset by more than the rounding of its coordinates, and a splinter keeps its shape. Far from the origin a step of the
/// seam lattice is more than the inset: there hulls are inset by that, up to the last bound.
inline constexpr double kLeastHullShrink = 0.001, kMostHullShrink = 0.25, kMostRoundedShrink = 0.75;

/// A convex hull for physics engines, in the fragment's local frame.
struct CollisionHull {
  std::vector<Vec3f> points;                            ///< at most 255
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise from outside
};

/// Of one fragment.
struct FragmentHulls {
  std::vector<CollisionHull> hulls;  ///< one for each body (member cell), or fewer (aggregate_hulls.hpp)
  std::uint32_t flat = 0;  ///< bodies too thin for a hull (1e-5 of their extent): theirs is a small cube
  std::uint32_t simplified = 0;  ///< had more than kMaxHullPoints extreme points: some were left out
  double volume = 0;             ///< m³, of all hulls, before they are moved inwards
  double excess = 0;  ///< `volume` relative to the fragment's, with closed cavities filled if it was divided
  /// For hull_trim.hpp: whether the hulls have been trimmed at contacts, if necessary, and the least share of its volume that
  /// one of the hulls kept.
  bool seen_contacts = false;
  double least_share = 1;
};

struct HullReport {
  std::uint32_t hulls = 0, flat = 0, simplified = 0;  ///< as FragmentHulls has them
  double excess = 0;                                  ///< the largest of a fragment; 0 without hulls
  bool operator==(const HullReport&) const = default;
};

/// A companion of a FragmentSet.
struct CollisionHulls {
  std::vector<FragmentHulls> of_fragment;  ///< one for each, or empty: none were asked for

  std::span<const CollisionHull> of(std::size_t fragment) const {
    if (of_fragment.empty()) return {};
    return of_fragment[fragment].hulls;
  }
  HullReport report() const;
};

inline constexpr std::uint32_t kMostHulls = 64;  ///< of a fragment, for HullLimits::count

/// How many hulls a fragment gets.
struct HullLimits {
  /// A fragment whose hulls have more than this many times its volume is divided (divided_hulls.hpp). At least 1; near 1, a
  /// bent fragment gets the maximum number of hulls.
  double excess = 1.5;
  std::uint32_t count = 4;  ///< at least 1
};

/// The hulls of every fragment that has a shape, in the fragment's local frame: those in `known`, which may be empty, or one
/// for each body. Fragments whose hulls exceed `limits.excess` get as many as their openings need, at most `limits.count`.
/// The set's lattice step says what rounding did to their corners. Throws Interrupted.
CollisionHulls make_collision_hulls(const FragmentSet& set, CollisionHulls known, const HullLimits& limits,
                                    const Execution& execution);

}  // namespace fracture
