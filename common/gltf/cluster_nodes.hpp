// The hierarchy as nodes: a cluster is a node without a mesh and without a transform whose children are the
// clusters of the next finer level, or the fragments. They stand behind all other nodes, so that a file
// without a hierarchy is what it always was.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/gltf/json_text.hpp"
#include "common/structure/hierarchy.hpp"

namespace fracture {

class ClusterNodes {
 public:
  /// `first_node`: the index of the first cluster's node. Throws Interrupted.
  ClusterNodes(const FracturedSolid& fractured, std::size_t first_node, const Execution& execution);

  /// What the root's children are: the coarsest clusters, or the fragments (nodes 1, 2, …) where there are no
  /// levels.
  const std::vector<std::size_t>& roots() const { return roots_; }
  /// Appends the nodes.
  void write(JsonText& json, const GltfOptions& options) const;

 private:
  struct Node {
    std::size_t level, cluster;
    std::vector<std::size_t> children;  // node indices
  };
  const Hierarchy& hierarchy_;
  std::string prefix_;
  std::vector<std::size_t> roots_;
  std::vector<Node> nodes_;
};

}  // namespace fracture
