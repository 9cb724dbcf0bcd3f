// The pipeline's result: the fragments of a solid and their companions. Each companion is made only from
// the set, in a separate module. Independent of file formats: gltf/ writes it, and tests check it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/rest.hpp"
#include "common/pipeline/report.hpp"
#include "common/structure/anchors.hpp"
#include "common/structure/hierarchy.hpp"
#include "common/structure/support.hpp"

namespace fracture {

/// Difference between a result and an earlier one (hits/difference.hpp). Contains ids of fragments, each
/// list in the order of its result. A companion of a FragmentSet.
struct Delta {
  std::vector<std::uint64_t> added, changed, gone;  ///< `changed` ones have a new shape
  /// Untouched fragments to which bonds lead, if the set has only the added and changed ones. A bond's
  /// index fragments.size() + k means neighbors[k].
  std::vector<std::uint64_t> neighbors;
};

/// The solid without cuts, for engines that show it until it breaks. A companion of a FragmentSet.
struct IntactSolid {
  std::vector<Fragment> parts;  ///< a fragment for each part, in the solid's frame (Pivot::kSource)
  CollisionHulls hulls;         ///< of the parts
};

/// Companions that were not requested are empty.
struct FracturedSolid {
  FragmentSet set;
  Hierarchy hierarchy;
  AnchoredFragments anchored;
  CollisionHulls hulls;
  std::optional<Rest> rest{};        ///< set with hulls
  std::optional<Support> support{};  ///< set if there are anchors, and density and strength are known
  std::optional<Delta> delta{};      ///< set if the result is compared with an earlier one
  std::optional<IntactSolid> intact{};
  Report report;
  /// Per site of the fragments: number of its input point (of the pattern, then of hits), the first one if
  /// several are equal. This number is published for Fragment::sites. If empty, site k is point k.
  std::vector<std::uint32_t> point_of_site{};
};

}  // namespace fracture
