// The hierarchy of the source as nodes: a group node for each node of the source that holds something. It is without a mesh and a
// transform. Its children are the pieces of the source's node, what of it stays whole, and the groups of the nodes below it. A
// fragment of several nodes is below their nearest common ancestor. Group nodes are the last nodes of the file. An answer
// to `fragment=` has no groups if the nodes of its source have no others above them, because all its surface is of one node.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/gltf/empty_nodes.hpp"
#include "common/gltf/intact_scene.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/passed_through.hpp"
#include "common/gltf/scene_layout.hpp"
#include "common/mesh/source_tree.hpp"
#include "common/pipeline/fractured_solid.hpp"

namespace fracture {

/// For each fragment, the node of the source that holds it: its own, or the nearest common ancestor of its nodes.
class SourceOfFragments {
 public:
  /// Borrows the source of `set`. Throws Interrupted.
  SourceOfFragments(const FragmentSet& set, const Execution& execution);

  /// Whether the source is more than one node. Otherwise, no fragment has one here.
  bool is_hierarchy() const { return is_hierarchy_; }
  const SourceNodes& nodes() const { return nodes_; }
  /// Index of SourceNodes, or kNoIndex: none.
  std::uint32_t of(std::size_t fragment) const { return is_hierarchy_ ? of_fragment_[fragment] : kNoIndex; }
  /// Writes the member {source: {index, name}}; nothing for kNoIndex. The index is the same in all answers to a mesh.
  void write(JsonText& json, std::uint32_t node) const;

 private:
  SourceNodes nodes_;
  bool is_hierarchy_;
  std::vector<std::uint32_t> of_fragment_;
};

class GroupNodes {
 public:
  /// `top`: node indices of the fragments or clusters that are the root's children without groups. `first_node`: index of the
  /// first group. Makes groups only if the source is a hierarchy and the fragments are not in clusters. Throws Interrupted.
  GroupNodes(const FracturedSolid& fractured, const SourceOfFragments& sources, const SceneLayout& layout,
             const std::vector<WholeNode>& whole, const IntactScene& intact, const EmptyNodes& empty,
             const std::vector<std::size_t>& top, std::size_t first_node, const Execution& execution);

  /// Node indices of the root's children, ascending, except that clusters come first.
  const std::vector<std::size_t>& of_root() const { return of_root_; }
  /// Appends the nodes.
  void write(JsonText& json) const;

 private:
  void place(std::uint32_t source, std::size_t node, std::vector<std::vector<std::size_t>>& held);

  const SourceOfFragments& sources_;
  struct Group {
    std::uint32_t source;
    std::string name;
    std::vector<std::size_t> children;  // node indices, ascending
  };
  std::vector<Group> groups_;  // ascending by source
  std::vector<std::size_t> of_root_;
};

}  // namespace fracture
