// Which pieces were united, in words that hold for a larger diagram as well: so that what no hit is near to stays
// united as it was.
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

/// Names a piece, whatever other cells there are, and however rough its cuts.
struct PieceName {
  SiteId lowest;  ///< of its owner's cells
  std::uint32_t part, island;
  std::uint32_t islands;  ///< so many pieces its owner has in the part
  auto operator<=>(const PieceName&) const = default;
};

/// Pieces that are one fragment: two or more, ascending.
using Union = std::vector<PieceName>;

/// Ascending, by parts of the whole. `lowest`: per owner the lowest of its cells, kNoSite: what is united with its pieces
/// has no name. Throws Interrupted, as all here.
std::vector<Union> name_unions(const RestrictedDiagram& diagram, const Pieces& pieces,
                               const PieceGroups& groups, const std::vector<SiteId>& lowest,
                               const Execution& execution);

/// Of all unions those that are not among the earlier ones, or have grown since. Both ascending.
std::vector<Union> unions_since(const std::vector<Union>& earlier, const std::vector<Union>& all);

/// Those of the unions of which no piece belongs to an owner that is `touched` (per owner), or is no owner any more.
std::vector<Union> active_unions(const std::vector<Union>& unions, const std::vector<SiteId>& lowest,
                                 const std::vector<char>& touched, const Execution& execution);

/// Unites the pieces of the diagram that the unions name, by parts of the whole. Where rough cuts made more or fewer
/// islands of a cell than flat ones its pieces stay apart: which is which cannot be said. Returns how many pieces became
/// part of another.
std::uint32_t unite_again(const std::vector<Union>& unions, const RestrictedDiagram& diagram,
                          const Pieces& pieces, const std::vector<SiteId>& lowest, PieceGroups& groups,
                          const Execution& execution);

/// Per owner the lowest of its cells.
std::vector<SiteId> lowest_cells(const Ownership& ownership);

/// Per owner: whether `is_later` is true for one of its cells, or for a Delaunay neighbour in the same frame of the map. If
/// not, its share of the solid is what it was without the later sites.
template <class IsLater>
std::vector<char> touched_owners(const Tetrahedralization& dual, const CellMap& map,
                                 const Ownership& ownership, const IsLater& is_later,
                                 const Execution& execution) {
  Pacer pacer(execution);
  std::vector<char> touched(ownership.sites_of_owner.size(), 0);
  for (const Tetrahedron& t : dual.tets) {
    pacer.step(4);
    unsigned frames = 0;  // a bit for each that has a later site
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
