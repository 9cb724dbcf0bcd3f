// Groups of pieces in order of their volumes, and their contacts, while the smallest groups are merged.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/contact_table.hpp"
#include "common/fragment/piece_groups.hpp"
#include "common/fragment/unite.hpp"

namespace fracture {

/// A heap of the groups, and tables of the area that each pair shares. When two groups merge, the contacts
/// of the group with fewer contacts move to the other, so a contact moves at most log2(n) times for n
/// contacts. So a group's entry in the tables (its seat) can differ from its name, which is always its
/// smallest piece. Every operation may throw Interrupted.
class SmallestFirst {
 public:
  /// `volumes`: per group, m³, indexed by its name. `across`: contacts between pieces of different parts;
  /// if null, such pieces do not merge. `kept_owner`: SizeLimits::kept_owner; groups with its pieces are not in
  /// the order.
  SmallestFirst(const RestrictedDiagram& diagram, const Pieces& pieces, const PieceGroups& groups,
                const std::vector<double>& volumes, const PartContacts* across, std::uint32_t kept_owner,
                const Execution& execution);
  SmallestFirst(const SmallestFirst&) = delete;  // its tables borrow its pacer
  SmallestFirst& operator=(const SmallestFirst&) = delete;

  std::uint32_t groups() const { return count_; }  ///< number of groups
  /// Whether a group that has not merged yet has a neighbour.
  bool has_neighbor(std::uint32_t group) const { return degree(seat_[group]) > 0; }
  /// Whether no group is left in the order. If false, smallest() and smallest_volume() may be called.
  bool done();
  double smallest_volume() const { return order_.front().volume; }  ///< m³
  std::uint32_t smallest() const { return order_.front().group; }
  /// Takes the smallest group out of the order until take_back(), or until a group merges with it.
  void leave_smallest();
  /// Puts back the groups that leave_smallest() took out.
  void take_back();
  /// Merges the smallest group with the neighbour that shares the largest cap area with it (ties: the lowest name). Kept
  /// groups come last. If it shares no caps, the neighbour is that of the largest contact across parts. Returns the names of both groups. If
  /// there is no neighbour, the group leaves the order, and both names are its own.
  std::pair<std::uint32_t, std::uint32_t> unite_smallest();

 private:
  struct Entry {
    double volume;
    std::uint32_t group, change;  ///< out of date if the group has changed since
  };
  static bool later(const Entry& a, const Entry& b) {
    return a.volume != b.volume ? a.volume > b.volume : a.group > b.group;
  }

  SmallestFirst(const Pieces& pieces, const PieceGroups& groups, const std::vector<double>& volumes,
                const std::vector<PieceContact>& caps, const PartContacts* across, std::uint32_t kept_owner,
                const Execution& execution);
  void add_across(const PartContacts& across, const PieceGroups& groups);
  /// The neighbour that shares the largest area, among kept groups or among the others.
  std::uint32_t nearest(const ContactTable& table, std::uint32_t group, bool kept) const;
  std::uint32_t nearest(std::uint32_t group) const;
  std::size_t degree(std::uint32_t seat) const;
  void push(std::uint32_t group);
  void pop();

  Pacer pacer_;
  std::vector<double> volume_;              // per group
  std::vector<std::uint32_t> name_, seat_;  // per seat: its group; per group: its seat
  std::vector<std::uint32_t> changes_;      // per group
  std::vector<char> is_kept_;               // per group
  ContactTable caps_;                       // between seats
  std::optional<ContactTable> across_;      // between seats
  std::vector<Entry> order_;                // a heap
  std::vector<Entry> left_;                 // taken out of the heap
  std::uint32_t count_ = 0;
};

}  // namespace fracture
