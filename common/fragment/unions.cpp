#include "common/fragment/unions.hpp"

#include <algorithm>
#include <string>
#include <tuple>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// kNoIndex: that cell is no owner's lowest.
std::uint32_t owner_of(SiteId cell, const std::vector<SiteId>& lowest) {
  const auto at = std::lower_bound(lowest.begin(), lowest.end(), cell);
  if (at == lowest.end() || *at != cell) return kNoIndex;
  return static_cast<std::uint32_t>(at - lowest.begin());
}

}  // namespace

std::vector<Union> name_unions(const Pieces& pieces, const PieceGroups& groups,
                               const std::vector<SiteId>& lowest, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Union> unions;
  for (std::uint32_t g = 0; g < groups.pieces(); ++g) {
    pacer.step();
    if (!groups.is_group(g) || groups.size(g) == 1) continue;
    Union& names = unions.emplace_back();
    for (const std::uint32_t p : groups.members(g, execution)) {  // in the order of owners, parts and islands
      const Piece& piece = pieces.pieces[p];
      names.push_back({lowest[piece.owners[0]], piece.part, piece.island});
    }
  }
  return unions;
}

std::vector<Union> active_unions(const std::vector<Union>& unions, const std::vector<SiteId>& lowest,
                                 const std::vector<char>& touched, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Union> active;
  for (const Union& pieces : unions) {
    pacer.step(16 * pieces.size());
    const bool is_active = std::none_of(pieces.begin(), pieces.end(), [&](const PieceName& piece) {
      const std::uint32_t owner = owner_of(piece.lowest, lowest);
      return owner == kNoIndex || touched[owner];
    });
    if (is_active) active.push_back(pieces);
  }
  return active;
}

std::uint32_t unite_again(const std::vector<Union>& unions, const RestrictedDiagram& diagram,
                          const Pieces& pieces, const std::vector<SiteId>& lowest, PieceGroups& groups,
                          const Execution& execution) {
  Pacer pacer(execution);
  const auto part_of = [&](const Piece& piece) {
    return diagram.part_in_whole ? (*diagram.part_in_whole)[piece.part] : piece.part;
  };
  const auto number = [&](const PieceName& name) {
    const std::uint32_t owner = owner_of(name.lowest, lowest);
    const auto at = std::lower_bound(
        pieces.pieces.begin(), pieces.pieces.end(), name, [&](const Piece& piece, const PieceName& wanted) {
          const std::uint32_t part = part_of(piece);
          return std::tie(piece.owners[0], part, piece.island) < std::tie(owner, wanted.part, wanted.island);
        });
    if (at == pieces.pieces.end() || at->owners[0] != owner || part_of(*at) != name.part ||
        at->island != name.island)
      throw InternalError("cell " + std::to_string(name.lowest) + " has no piece " +
                          std::to_string(name.island) + " in part " + std::to_string(name.part));
    return static_cast<std::uint32_t>(at - pieces.pieces.begin());
  };
  std::uint32_t united = 0;
  for (const Union& names : unions) {
    const std::uint32_t first = number(names[0]);
    for (std::size_t k = 1; k < names.size(); ++k, ++united) {
      pacer.step(64);
      groups.unite(first, number(names[k]), pacer);
    }
  }
  return united;
}

std::vector<SiteId> lowest_cells(const Ownership& ownership) {
  std::vector<SiteId> lowest;
  lowest.reserve(ownership.sites_of_owner.size());
  for (const std::vector<SiteId>& cells : ownership.sites_of_owner) lowest.push_back(cells[0]);
  return lowest;
}

}  // namespace fracture
