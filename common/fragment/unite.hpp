// Pieces that become one fragment: who touches whom, which are too small to stay alone, and the faces of what
// is united. An exact union: the caps between the pieces disappear on both sides, and so do the cuts between
// them in the outer surface.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/size_limits.hpp"

namespace fracture {

/// Pieces joined so far: a group is named by its smallest piece.
class PieceGroups {
 public:
  explicit PieceGroups(std::size_t pieces);
  const std::vector<std::uint32_t>& of_piece() const { return group_; }
  /// Ascending; empty when `group` is not the name of one.
  const std::vector<std::uint32_t>& members(std::uint32_t group) const { return members_[group]; }
  bool is_group(std::uint32_t piece) const { return group_[piece] == piece; }
  void unite(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<std::uint32_t> group_;
  std::vector<std::vector<std::uint32_t>> members_;
};

/// Two groups of pieces that share caps.
struct Contact {
  std::uint32_t of, with;
  double area;  ///< m²; 0 where they touch without a bond
};
/// Both directions of each pair; by `of`, then the largest area first, ties by `with`.
std::vector<Contact> find_contacts(const RestrictedDiagram& diagram, const Pieces& pieces,
                                   const std::vector<std::uint32_t>& group_of_piece);

/// The faces of a group of pieces as one piece.
Piece join_pieces(const RestrictedDiagram& diagram, const Pieces& pieces,
                  const std::vector<std::uint32_t>& members,
                  const std::vector<std::uint32_t>& group_of_piece);

/// Unites the smallest piece with the neighbour of largest shared cap area (ties: the lowest piece), again
/// and again, as long as the limits ask for it. Which pieces that are is a function of the unrounded volumes.
SizeFigures unite_by_size(const RestrictedDiagram& diagram, const Pieces& pieces, const SizeLimits& limits,
                          PieceGroups& groups, const Execution& execution);

}  // namespace fracture
