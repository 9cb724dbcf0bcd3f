// Which fragments must not collide with one another. Hulls of different cells cannot overlap, because cells
// are convex; but the hulls of several pieces of one cell (islands, or parts of the solid that overlap) can,
// and a solver throws such a pair apart at spawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

struct CollisionSystems {
  std::size_t count = 0;
  /// Per fragment: its system, numbered in order of the fragments, or kNoIndex for a fragment that shares no
  /// cell with another. Fragments that share a site are in the same system, also by way of a third.
  std::vector<std::uint32_t> of_fragment;
};

/// Throws Interrupted.
CollisionSystems collision_systems(const FragmentSet& set, const Execution& execution = {});

}  // namespace fracture
