// Fragments (or clusters of them) and their bonds as a graph, with a node per fragment and an edge per
// bond.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

class BondGraph {
 public:
  struct Node {
    double volume;  ///< m³
    Vec3d center;   ///< centre of mass, m
  };
  struct Edge {
    std::uint32_t to, bond;  ///< index of the bond
    double area;             ///< m²
  };

  /// Throws Interrupted.
  BondGraph(std::vector<Node> nodes, const std::vector<Bond>& bonds, const Execution& execution = {});
  static BondGraph of_fragments(const FragmentSet& set, const Execution& execution = {});

  std::uint32_t size() const { return static_cast<std::uint32_t>(nodes_.size()); }
  const Node& node(std::uint32_t n) const { return nodes_[n]; }
  /// The edges of a node, in the order of the bonds.
  std::span<const Edge> edges(std::uint32_t n) const {
    return {edges_.data() + begin_[n], edges_.data() + begin_[n + 1]};
  }
  /// Returns, per node, the lowest node of its connected component. Throws Interrupted.
  std::vector<std::uint32_t> components(const Execution& execution = {}) const;

 private:
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> begin_;
  std::vector<Edge> edges_;
};

/// Returns the bonds between groups of nodes. The area is the sum; centroid, normal and strength are means
/// weighted by area. The normal points from the lower group to the higher. group_of_node[n]: group of node
/// n, numbered from 0. Bonds within a group disappear. Ascending by (a, b). Throws Interrupted.
std::vector<Bond> bonds_between(const std::vector<Bond>& bonds,
                                const std::vector<std::uint32_t>& group_of_node,
                                const Execution& execution = {});

}  // namespace fracture
