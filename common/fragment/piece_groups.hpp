// Which pieces were united so far.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"

namespace fracture {

/// Disjoint sets of pieces. A group is named by its smallest piece. The larger set keeps its number and the
/// members of the smaller one are renumbered, each of n pieces at most log2(n) times; a question costs one
/// look at a table, so that many threads may ask.
class PieceGroups {
 public:
  explicit PieceGroups(std::size_t pieces);

  std::size_t pieces() const { return set_.size(); }
  /// The name of the group that has this piece.
  std::uint32_t of(std::uint32_t piece) const { return name_[set_[piece]]; }
  bool is_group(std::uint32_t piece) const { return of(piece) == piece; }
  std::uint32_t size(std::uint32_t group) const { return size_[set_[group]]; }
  /// Ascending. Throws Interrupted.
  std::vector<std::uint32_t> members(std::uint32_t group, const Execution& execution = {}) const;
  /// of() every piece.
  std::vector<std::uint32_t> names() const;

  /// Numbers of sets, below pieces(): unlike its name, the number of a set is that of one of the two it was
  /// made of. For tables of what is known of a set.
  std::uint32_t set_of(std::uint32_t piece) const { return set_[piece]; }
  std::uint32_t name_of_set(std::uint32_t set) const { return name_[set]; }

  struct Union {
    std::uint32_t kept, gone;  ///< numbers of sets; equal where both were one already
  };
  /// Unites the groups that have these pieces; n log n for all unions together, one may move half of all.
  /// Throws Interrupted, which leaves the groups in disorder.
  Union unite(std::uint32_t a, std::uint32_t b, Pacer& pacer);

 private:
  std::vector<std::uint32_t> set_, next_;   // per piece: its set; another member, in a circle
  std::vector<std::uint32_t> name_, size_;  // per set
};

}  // namespace fracture
