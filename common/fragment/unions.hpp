// Names for united pieces that also apply in a larger diagram. So pieces far from every new hit stay united
// as they were.
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
/// lowest cell. If that is kNoSite, unions with the owner's pieces have no name and are left out. Throws
/// Interrupted, like all functions here.
std::vector<Union> name_unions(const RestrictedDiagram& diagram, const Pieces& pieces,
                               const PieceGroups& groups, const std::vector<SiteId>& lowest,
                               const Execution& execution);

/// Returns the unions in `all` that are not among the earlier ones, or have grown since. Both are
/// ascending.
std::vector<Union> unions_since(const std::vector<Union>& earlier, const std::vector<Union>& all);

/// Returns the unions whose pieces all belong to owners that still exist and are not `touched` (per owner).
std::vector<Union> active_unions(const std::vector<Union>& unions, const std::vector<SiteId>& lowest,
                                 const std::vector<char>& touched, const Execution& execution);

/// Unites the pieces of the diagram that the unions name, with part numbers of the whole. If rough cuts
/// split a cell into more or fewer islands than flat ones, its pieces cannot be identified and their unions
/// are skipped. Returns the number of pieces that became part of another.
std::uint32_t unite_again(const std::vector<Union>& unions, const RestrictedDiagram& diagram,
                          const Pieces& pieces, const std::vector<SiteId>& lowest, PieceGroups& groups,
                          const Execution& execution);

/// Returns, per owner, its lowest cell.
std::vector<SiteId> lowest_cells(const Ownership& ownership);

/// Returns, per owner, whether `is_later` is true for one of its cells, or for a Delaunay neighbour in the
/// same frame of the map. If not, its share of the solid is the same as without the later sites.
template <class IsLater>
std::vector<char> touched_owners(const Tetrahedralization& dual, const CellMap& map,
                                 const Ownership& ownership, const IsLater& is_later,
                                 const Execution& execution) {
  Pacer pacer(execution);
  std::vector<char> touched(ownership.sites_of_owner.size(), 0);
  for (const Tetrahedron& t : dual.tets) {
    pacer.step(4);
    unsigned frames = 0;  // a bit for each frame that has a later site
    for (const SiteId s : t.v)
      if (!dual.is_corner(s) && is_later(s)) frames |= 1u << map.index_at(dual.points[s]);
    if (frames == 0) continue;
    for (const SiteId s : t.v)
      if (!dual.is_corner(s) && (frames >> map.index_at(dual.points[s]) & 1) != 0)
        touched[ownership.owner_of_site[s]] = 1;
  }
  return touched;
}

}  // namespace fracture
