// Names for united pieces that do not depend on how rough their cuts are. So flat cuts decide which pieces unite.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/base/execution.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/fragment/piece_groups.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Names a piece independently of other cells and of how rough its cuts are.
struct PieceName {
  SiteId lowest;  ///< lowest of its owner's cells
  std::uint32_t part, island;
  std::uint32_t islands;  ///< number of pieces of its owner in the part
  auto operator<=>(const PieceName&) const = default;
};

/// Pieces that form one fragment: two or more, ascending.
using Union = std::vector<PieceName>;

/// Returns the unions of all groups, ascending, with part numbers of the whole. `lowest`: per owner, its
/// lowest cell. Throws Interrupted, like all functions here.
std::vector<Union> name_unions(const RestrictedDiagram& diagram, const Pieces& pieces,
                               const PieceGroups& groups, const std::vector<SiteId>& lowest,
                               const Execution& execution);

/// Unites the pieces of the diagram that the unions name, with part numbers of the whole. If rough cuts
/// split a cell into more or fewer islands than flat ones, its pieces cannot be identified and their unions
/// are skipped. Returns the number of pieces that became part of another.
std::uint32_t unite_again(const std::vector<Union>& unions, const RestrictedDiagram& diagram,
                          const Pieces& pieces, const std::vector<SiteId>& lowest, PieceGroups& groups,
                          const Execution& execution);

/// Returns, per owner, its lowest cell.
std::vector<SiteId> lowest_cells(const Ownership& ownership);

}  // namespace fracture
