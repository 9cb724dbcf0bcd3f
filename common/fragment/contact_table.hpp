// The areas that pairs of sets share, while sets unite.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// A graph with a weight on each edge whose nodes are merged: each edge stands in the lists of its two nodes
/// and in a hash table by them (open addressing, linear probing). Flat arrays alone: millions of contacts are
/// given back at once, also by an interruption. All borrow the caller's pacer and throw Interrupted.
class ContactTable {
 public:
  /// For nodes 0 .. nodes - 1 and at most so many edges.
  ContactTable(std::uint32_t nodes, std::size_t edges, Pacer& pacer);

  /// Adds to what a and b share; a != b.
  void add(std::uint32_t a, std::uint32_t b, double area);
  std::uint32_t degree(std::uint32_t node) const { return degree_[node]; }
  /// Calls visit(other, area) for each node that touches this one, in an order that nothing may depend on.
  template <class Visit>
  void visit(std::uint32_t node, const Visit& visit) const {
    for (Side s = first_[node]; s != kNone; s = next_[s]) {
      pacer_.step(8);
      visit(node_[s ^ 1], area_[s / 2]);
    }
  }
  /// What `gone` touches, `kept` touches instead; what they share is forgotten. The time is that of the
  /// edges of `gone`.
  void merge(std::uint32_t kept, std::uint32_t gone);

 private:
  using Side = std::uint32_t;  ///< edge e has the sides 2 e and 2 e + 1, one at each of its nodes
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::size_t home(std::uint32_t a, std::uint32_t b) const;
  /// Where the edge of a and b stands in the table, or where it would.
  std::size_t place(std::uint32_t a, std::uint32_t b) const;
  void forget(std::size_t place);
  void link(Side side, std::uint32_t node);
  void unlink(Side side);

  Pacer& pacer_;
  std::vector<Side> first_;            // per node
  std::vector<std::uint32_t> degree_;  // per node
  std::vector<std::uint32_t> node_;    // per side
  std::vector<Side> next_, before_;    // per side: in the list of its node
  std::vector<double> area_;           // per edge
  std::vector<std::uint32_t> table_;   // edges
  std::size_t mask_ = 0;               // its size less one, a power of two
};

}  // namespace fracture
