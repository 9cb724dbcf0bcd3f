// The nodes of a mesh's source as a tree. Answers have a group node for each of them that holds something.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/id.hpp"

namespace fracture {

struct Mesh;

/// Maximum number of nodes between the root and a fragment. Nodes below others of this depth count as the lowest of these,
/// because readers visit nodes by recursion.
inline constexpr std::uint32_t kMostSourceLevels = 64;

struct SourceNode {
  std::string name;  ///< UTF-8, not empty, possibly repeated
  std::uint32_t parent =
      kNoIndex;  ///< index into SourceTree::nodes, lower than the node's own; kNoIndex: none
  /// Members of the extras of a node without a mesh, as in Mesh::node_extras. Fragments carry those of nodes with a mesh.
  std::string extras{};
  friend bool operator==(const SourceNode&, const SourceNode&) = default;
};

/// Nodes that are without a name and a mesh are not in it.
struct SourceTree {
  std::vector<SourceNode> nodes;  ///< in the order of a depth-first walk: parents come before their children
  /// Per Mesh::node_names: its node. Ascending, but all instances of one node are the same. Instances are therefore in the order
  /// of the walk, too.
  std::vector<std::uint32_t> of_instance;
  friend bool operator==(const SourceTree&, const SourceTree&) = default;
};

/// The least and the greatest of some mesh instances (indices into Mesh::node_names). In the order of a depth-first walk, their
/// nearest common ancestor is that of all of them.
struct NodeRange {
  std::uint32_t first = kNoIndex, last = 0;  ///< by default none
  void add(std::uint32_t node) { *this = {std::min(first, node), std::max(last, node)}; }
  void add(const NodeRange& o) { *this = {std::min(first, o.first), std::max(last, o.last)}; }
  friend bool operator==(const NodeRange&, const NodeRange&) = default;
};

/// The tree of a mesh. Without Mesh::source_tree, each of Mesh::node_names is a node without a parent. Borrows the mesh.
class SourceNodes {
 public:
  explicit SourceNodes(const Mesh& mesh) : mesh_(mesh) {}

  std::size_t size() const;
  const std::string& name(std::uint32_t node) const;
  std::uint32_t parent(std::uint32_t node) const;
  const std::string& extras(std::uint32_t node) const;
  /// Returns the node of a mesh instance. For an unknown instance, returns kNoIndex.
  std::uint32_t of_instance(std::uint32_t instance) const;
  /// Returns the nearest common ancestor of the instances, which may be their own node, or kNoIndex: none. Takes at most
  /// 2 × kMostSourceLevels steps.
  std::uint32_t common_ancestor(const NodeRange& instances) const;
  /// Returns whether the mesh, with what Mesh::passed_through keeps of it, has triangles of different nodes, or of a node below
  /// another one. Otherwise, the tree says nothing. Throws Interrupted.
  bool is_hierarchy(const Execution& execution) const;

 private:
  const Mesh& mesh_;
};

}  // namespace fracture
