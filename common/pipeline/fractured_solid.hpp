// The pipeline's result: the fragments of a solid and their companions. Each companion is made only from
// the set, in a separate module. Independent of file formats: gltf/ writes it, and tests check it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/similarity.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/rest.hpp"
#include "common/pipeline/report.hpp"
#include "common/structure/anchors.hpp"
#include "common/structure/hierarchy.hpp"
#include "common/structure/support.hpp"
#include "common/structure/whole_bonds.hpp"

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
  std::vector<Fragment> parts;          ///< a fragment for each part, in the solid's frame (Pivot::kSource)
  CollisionHulls hulls;                 ///< of the parts
  std::vector<std::string> warnings{};  ///< see Remarks
};

/// The fragments that are whole instances of a mesh (solid/instances.hpp). The file contains each shape once, and a node for each
/// fragment that places it. A companion of a FragmentSet.
struct InstancedBodies {
  /// Places a shape: rotation (unit quaternion x, y, z, w), uniform scale and translation, as numbers of the file.
  struct Body {
    std::uint32_t shape = 0;
    std::array<float, 4> rotation{0, 0, 0, 1};
    float scale = 1;
    Vec3d translation;  ///< a multiple of the seam lattice's step on each axis
    Similarity place() const {
      return {{rotation[0], rotation[1], rotation[2], rotation[3]}, scale, translation};
    }
    friend bool operator==(const Body&, const Body&) = default;
    bool is_turned() const { return rotation != std::array<float, 4>{0, 0, 0, 1}; }
  };
  std::vector<Fragment> shapes;      ///< local positions; bits of the largest instance
  std::vector<FragmentHulls> hulls;  ///< of the shapes; empty without hulls
  /// Per shape: its number, which hits do not change (`shape` in the file)
  std::vector<std::uint32_t> numbers;
  std::vector<Body> bodies;
  /// Per fragment: index into `bodies`, or kNoIndex; empty: there are none
  std::vector<std::uint32_t> of_fragment;

  const Body* of(std::size_t fragment) const {
    if (of_fragment.empty() || of_fragment[fragment] == kNoIndex) return nullptr;
    return &bodies[of_fragment[fragment]];
  }
};

/// Companions that were not requested are empty.
struct FracturedSolid {
  FragmentSet set;
  Hierarchy hierarchy;
  AnchoredFragments anchored;
  CollisionHulls hulls;
  InstancedBodies instances;
  std::vector<WholeBond> whole_bonds{};  ///< with nodes that are not fractured
  std::optional<Rest> rest{};            ///< set with hulls
  std::optional<Support> support{};      ///< set if there are anchors, and density and strength are known
  std::optional<Delta> delta{};          ///< set if the result is compared with an earlier one
  std::optional<IntactSolid> intact{};
  Report report;
  /// Per site of the fragments: number of its input point (of the pattern, then of hits), the first one if
  /// several are equal. This number is published for Fragment::sites. If empty, site k is point k.
  std::vector<std::uint32_t> point_of_site{};
};

}  // namespace fracture
