// Contact areas between pairs of sets, while sets are united.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// A graph with weighted edges whose nodes can be merged. Each edge is in the lists of its two nodes and in
/// a hash table keyed by both nodes (open addressing, linear probing). Only flat arrays are used, so
/// millions of contacts are freed at once, even after an interruption. All functions use the caller's pacer
/// and throw Interrupted.
class ContactTable {
 public:
  /// Creates a table for nodes 0 .. nodes - 1 and at most `edges` edges.
  ContactTable(std::uint32_t nodes, std::size_t edges, Pacer& pacer);

  /// Adds `area` to the area that a and b share; a != b.
  void add(std::uint32_t a, std::uint32_t b, double area);
  std::uint32_t degree(std::uint32_t node) const { return degree_[node]; }
  /// Calls visit(other, area) for each node that touches this one. No result may depend on the order.
  template <class Visit>
  void visit(std::uint32_t node, const Visit& visit) const {
    for (Side s = first_[node]; s != kNone; s = next_[s]) {
      pacer_.step(8);
      visit(node_[s ^ 1], area_[s / 2]);
    }
  }
  /// Moves the contacts of `gone` to `kept` and removes the contact between the two. Takes time
  /// proportional to the number of edges of `gone`.
  void merge(std::uint32_t kept, std::uint32_t gone);

 private:
  using Side = std::uint32_t;  ///< edge e has the sides 2 e and 2 e + 1, one at each of its nodes
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::size_t home(std::uint32_t a, std::uint32_t b) const;
  /// Place of the edge between a and b in the table, or the free place for it.
  std::size_t place(std::uint32_t a, std::uint32_t b) const;
  void forget(std::size_t place);
  void link(Side side, std::uint32_t node);
  void unlink(Side side);

  Pacer& pacer_;
  std::vector<Side> first_;            // per node
  std::vector<std::uint32_t> degree_;  // per node
  std::vector<std::uint32_t> node_;    // per side
  std::vector<Side> next_, before_;    // per side: its neighbours in its node's list
  std::vector<double> area_;           // per edge
  std::vector<std::uint32_t> table_;   // per place: its edge, or kNone
  std::size_t mask_ = 0;               // the table's size minus 1; the size is a power of two
};

}  // namespace fracture
