// The parts of the scene that were not fractured (Mesh::passed_through), as plain mesh nodes: under their own
// names, without extras.fracture, without physics.
#pragma once

#include <string>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

struct WholeNode {
  std::string name;  ///< the source's, as ASCII; a number is added where another node or mesh has it
  /// What the mesh writer needs of a fragment: positions in the frame of the scene, attributes, indices,
  /// primitives in material order (triangles without a material last).
  Fragment mesh;
};

/// One for each node of the source that keeps triangles, in source order. Throws Interrupted.
std::vector<WholeNode> whole_nodes(const FragmentSet& set, const SceneLayout& layout,
                                   const Execution& execution);

}  // namespace fracture
