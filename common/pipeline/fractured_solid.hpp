// What leaves the pipeline: the fragments of a solid with their companions, each made by its own room from the
// set alone. File-format free: gltf/ writes it down, tests judge it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/pipeline/report.hpp"
#include "common/structure/anchors.hpp"
#include "common/structure/hierarchy.hpp"
#include "common/structure/support.hpp"

namespace fracture {

/// How an answer differs from an earlier one (hits/difference.hpp).
/// Ids of fragments, each list in the order of its answer. A companion of a FragmentSet.
struct Delta {
  std::vector<std::uint64_t> added, changed, gone;  ///< `changed` ones have a new shape
  /// Untouched fragments that bonds lead to, where the set has only what was added and changed: a bond's
  /// index of fragments.size() + k means neighbors[k].
  std::vector<std::uint64_t> neighbors;
};

/// The solid without cuts, for engines that show it until it breaks. A companion of a FragmentSet.
struct IntactSolid {
  std::vector<Fragment> parts;  ///< a fragment for each part, in the solid's frame (Pivot::kSource)
  CollisionHulls hulls;         ///< of the parts
};

/// Companions that were not asked for are empty.
struct FracturedSolid {
  FragmentSet set;
  Hierarchy hierarchy;
  AnchoredFragments anchored;
  CollisionHulls hulls;
  std::optional<Support> support{};  ///< where there are anchors, by who knows density and strength
  std::optional<Delta> delta{};      ///< where the answer is compared with an earlier one
  std::optional<IntactSolid> intact{};
  Report report;
  /// Per site of the fragments which point it is of those given (of the pattern, then of hits), and of equal ones the first:
  /// what is published of Fragment::sites. Empty: site k is point k.
  std::vector<std::uint32_t> point_of_site{};
};

}  // namespace fracture
