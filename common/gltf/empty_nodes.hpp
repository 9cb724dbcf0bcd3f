// Nodes of the source without a mesh (Mesh::empty_nodes), below the root of the fragments. Only group nodes come after them,
// so they do not change the indices of others.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/gltf/json_text.hpp"
#include "common/gltf/passed_through.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

class EmptyNodes {
 public:
  /// `first_node`: index of the first one. There are none in a file without fragments. Borrows `set`. Throws Interrupted.
  EmptyNodes(const FragmentSet& set, const SceneLayout& layout, const std::vector<WholeNode>& whole,
             std::size_t first_node, const Execution& execution);

  std::size_t size() const { return names_.size(); }
  std::size_t first_node() const { return first_node_; }
  const std::vector<std::string>& names() const { return names_; }
  /// Appends the nodes: {name, translation or matrix, extras}. A transform that does nothing is left out.
  void write(JsonText& json) const;

 private:
  const FragmentSet& set_;
  std::size_t first_node_;
  std::vector<std::string> names_;  ///< the source's; a number is added if the name is taken
};

}  // namespace fracture
