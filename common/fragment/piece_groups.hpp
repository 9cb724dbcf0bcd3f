// Groups of united pieces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"

namespace fracture {

/// Disjoint sets of pieces. The name of a group is its smallest piece. In a union, the larger set keeps its
/// number and the members of the smaller one are renumbered, so each of n pieces is renumbered at most
/// log2(n) times. Queries only read tables, so many threads may run them.
class PieceGroups {
 public:
  explicit PieceGroups(std::size_t pieces);

  std::size_t pieces() const { return set_.size(); }
  /// The name of the group that contains this piece.
  std::uint32_t of(std::uint32_t piece) const { return name_[set_[piece]]; }
  bool is_group(std::uint32_t piece) const { return of(piece) == piece; }
  std::uint32_t size(std::uint32_t group) const { return size_[set_[group]]; }
  /// Ascending. Throws Interrupted.
  std::vector<std::uint32_t> members(std::uint32_t group, const Execution& execution = {}) const;
  /// of() for every piece.
  std::vector<std::uint32_t> names() const;

  /// Number of the piece's set, below pieces(). A union keeps the number of one of its two sets, which may
  /// differ from its name. Use it to index data about sets.
  std::uint32_t set_of(std::uint32_t piece) const { return set_[piece]; }
  std::uint32_t name_of_set(std::uint32_t set) const { return name_[set]; }

  struct Union {
    std::uint32_t kept, gone;  ///< numbers of sets; equal if both pieces were in one set already
  };
  /// Unites the groups that contain these pieces. All unions together take n log n; a single one may move
  /// half of all pieces. Throws Interrupted, which leaves the groups inconsistent.
  Union unite(std::uint32_t a, std::uint32_t b, Pacer& pacer);

 private:
  std::vector<std::uint32_t> set_, next_;   // per piece: its set; the next member, in a circle
  std::vector<std::uint32_t> name_, size_;  // per set
};

}  // namespace fracture
