// Unites pieces into one fragment: finds pieces that touch, picks those that are too small, and joins
// faces. Pieces of one part become an exact union: the caps between them disappear on both sides, and so do
// the cuts between them in the outer surface. Pieces of different parts stay separate closed shells within
// the fragment.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/piece_groups.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/size_limits.hpp"

namespace fracture {

/// Two pieces, or groups of them, that touch.
struct PieceContact {
  std::uint32_t of, with;
  double area;  ///< m²; 0 if they touch without a bond
};
/// The contacts that hold pieces of different parts together (pipeline/part_contacts.hpp).
struct PartContacts {
  /// Each pair once; pieces that overlap in a cell without a bond have area 0
  std::vector<PieceContact> pieces;
  /// Per part: the group of parts that hold together, numbered from 0
  std::vector<std::uint32_t> group_of_part;
  /// Per part: the instance that stays whole and contains it, or kNoIndex. Empty: none stays whole. `pieces` has no contacts of
  /// these parts.
  std::vector<std::uint32_t> whole{};
  bool whole_touch = false;  ///< whether an instance that stays whole touches another part
};

/// Finds groups that share caps. Each pair is listed in both directions, sorted by `of`, then by largest
/// area, ties by `with`. Throws Interrupted.
std::vector<PieceContact> find_piece_contacts(const RestrictedDiagram& diagram, const Pieces& pieces,
                                              const std::vector<std::uint32_t>& group_of_piece,
                                              const Execution& execution);

/// Returns the volume of each group of pieces, m³, indexed by its name; 0 if there is no group of that
/// name. `weights`: SizeLimits::weights. Throws Interrupted.
std::vector<double> volumes_of_groups(const RestrictedDiagram& diagram, const Pieces& pieces,
                                      const PieceGroups& groups, const Execution& execution,
                                      const std::vector<double>& weights = {});

/// Returns the total volume of the member pieces in each part, ascending by part in the whole. Throws
/// Interrupted.
std::vector<PartVolume> volumes_of_parts(const RestrictedDiagram& diagram, const Pieces& pieces,
                                         const std::vector<std::uint32_t>& members,
                                         const Execution& execution);

/// Returns a group of pieces as one piece. Throws Interrupted.
Piece join_pieces(const RestrictedDiagram& diagram, const Pieces& pieces, const PieceGroups& groups,
                  std::uint32_t group, const Execution& execution);

/// If `across` is not null, first joins all pieces of each instance that stays whole, and the pieces of other parts that touch in
/// one cell. Then
/// repeatedly merges the smallest group of pieces with the neighbour of largest shared cap area (ties: the
/// lowest piece), as long as the limits ask for it. A group without caps merges with the neighbour of its
/// largest contact in `across`. Groups without neighbours and almost without volume take no fragment from other groups of the
/// same parts (SizeLimits::fragments).
/// The choice depends only on the unrounded volumes. `groups`: pieces that are
/// united already; none if SizeLimits::fragments is set. Near-linear in pieces and contacts; with a
/// triangle budget, near-linear in triangles, too. Throws Interrupted.
SizeFigures unite_by_size(const RestrictedDiagram& diagram, const Pieces& pieces, const SizeLimits& limits,
                          const PartContacts* across, PieceGroups& groups, const Execution& execution);

}  // namespace fracture
