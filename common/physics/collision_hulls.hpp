// Convex collision hulls: what a physics engine collides instead of the visible mesh. The part of a fragment
// in one cell lies in that convex cell, hence so does its hull, and hulls of neighbours cannot overlap;
// shrunk a little towards their centres they do not even touch (hulls that touch exactly are pushed apart by
// the solver at spawn).
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Most engines cap convex hulls at 255 or 256 points.
inline constexpr std::uint32_t kMaxHullPoints = 255;
/// Each hull is scaled by 1 - kHullShrink about the mean of its points.
inline constexpr double kHullShrink = 0.001;

struct HullReport {
  std::uint32_t hulls = 0;
  std::uint32_t flat = 0;  ///< bodies too thin for a hull (a box of their extent stands in, at least 1e-6 of
                           ///< the fragment thick)
  std::uint32_t simplified =
      0;  ///< had more than kMaxHullPoints points: extreme points in fixed directions were kept
};

/// Fills Fragment::hulls of every fragment: one hull for each body (member cell), in the fragment's local
/// frame.
HullReport add_collision_hulls(FragmentSet& set, const Execution& execution);

}  // namespace fracture
