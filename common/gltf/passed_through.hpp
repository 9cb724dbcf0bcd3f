// The parts of the scene that were not fractured (Mesh::passed_through, and sheets that stay whole), as plain mesh
// nodes. They keep their names and have neither extras.fracture nor physics. `extras.whole.node` is their number in the
// mesh, which bonds name.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

struct WholeNode {
  std::uint32_t node;  ///< index into Mesh::node_names
  std::string name;    ///< the source's, see kept_name(); a number is added if the name is taken
  std::string extras;  ///< the source's (Mesh::node_extras)
  /// Only the members that the mesh writer needs: positions in the scene's frame, attributes, indices, and
  /// primitives in material order (triangles without a material last).
  Fragment mesh;
};

/// Writes a node {name, mesh, extras}.
void write_whole_node(JsonText& json, const std::string& name, std::size_t mesh, const std::string& extras);

/// Returns one for each node of the source that keeps triangles, in the source's order. Nodes with sheets come last.
/// Throws Interrupted.
std::vector<WholeNode> whole_nodes(const FragmentSet& set, const SceneLayout& layout,
                                   const Execution& execution);

}  // namespace fracture
