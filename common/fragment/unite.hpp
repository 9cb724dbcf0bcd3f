// Pieces that become one fragment: who touches whom, which are too small to stay alone, and the faces of what
// is united. An exact union: the caps between the pieces disappear on both sides, and so do the cuts between
// them in the outer surface.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/piece_groups.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/size_limits.hpp"

namespace fracture {

/// Two groups of pieces that share caps.
struct PieceContact {
  std::uint32_t of, with;
  double area;  ///< m²; 0 where they touch without a bond
};
/// Both directions of each pair; by `of`, then the largest area first, ties by `with`. Throws Interrupted.
std::vector<PieceContact> find_piece_contacts(const RestrictedDiagram& diagram, const Pieces& pieces,
                                              const std::vector<std::uint32_t>& group_of_piece,
                                              const Execution& execution);

/// Of each group of pieces, by its name, m³; 0 where there is no group of that name. Throws Interrupted.
std::vector<double> volumes_of_groups(const RestrictedDiagram& diagram, const Pieces& pieces,
                                      const PieceGroups& groups, const Execution& execution);

/// The faces of a group of pieces as one piece. Throws Interrupted.
Piece join_pieces(const RestrictedDiagram& diagram, const Pieces& pieces, const PieceGroups& groups,
                  std::uint32_t group, const Execution& execution);

/// Unites the smallest group of pieces with the neighbour of largest shared cap area (ties: the lowest piece), again
/// and again, as long as the limits ask for it. Which pieces that are is a function of the unrounded volumes. `groups`:
/// what is united already; nothing where SizeLimits::fragments is set.
/// Near-linear in pieces and caps, and for a budget of triangles in these. Throws Interrupted.
SizeFigures unite_by_size(const RestrictedDiagram& diagram, const Pieces& pieces, const SizeLimits& limits,
                          PieceGroups& groups, const Execution& execution);

}  // namespace fracture
