// The hierarchy as nodes. A cluster is a node without a mesh and without a transform. Its children are the
// clusters of the next finer level, or the fragments. Cluster nodes follow all other nodes, so they do not
// change the indices of the others.
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
  /// `first_node`: node index of the first cluster. Throws Interrupted.
  ClusterNodes(const FracturedSolid& fractured, std::size_t first_node, const Execution& execution);

  /// Node indices of the root's children: the coarsest clusters, or the fragments (nodes 1, 2, …) if there are no
  /// levels.
  const std::vector<std::size_t>& roots() const { return roots_; }
  std::size_t size() const { return nodes_.size(); }
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
