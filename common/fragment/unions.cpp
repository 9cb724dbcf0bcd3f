#include "common/fragment/unions.hpp"

#include <algorithm>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// Returns the owner whose lowest cell this is, or kNoIndex.
std::uint32_t owner_of(SiteId cell, const std::vector<SiteId>& lowest) {
  const auto at = std::lower_bound(lowest.begin(), lowest.end(), cell);
  if (at == lowest.end() || *at != cell) return kNoIndex;
  return static_cast<std::uint32_t>(at - lowest.begin());
}

std::uint32_t part_in_whole(const RestrictedDiagram& diagram, const Piece& piece) {
  return diagram.part_in_whole ? (*diagram.part_in_whole)[piece.part] : piece.part;
}

}  // namespace

std::vector<Union> name_unions(const RestrictedDiagram& diagram, const Pieces& pieces,
                               const PieceGroups& groups, const std::vector<SiteId>& lowest,
                               const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::uint32_t> islands(pieces.pieces.size());  // of the piece's owner and part
  for (std::size_t p = pieces.pieces.size(); p-- > 0;) {
    pacer.step();
    const Piece& piece = pieces.pieces[p];
    islands[p] = p + 1 < islands.size() && pieces.pieces[p + 1].island > piece.island ? islands[p + 1]
                                                                                      : piece.island + 1;
  }
  std::vector<Union> unions;
  for (std::uint32_t g = 0; g < groups.pieces(); ++g) {
    pacer.step();
    if (!groups.is_group(g) || groups.size(g) == 1) continue;
    Union names;
    for (const std::uint32_t p : groups.members(g, execution)) {
      const Piece& piece = pieces.pieces[p];
      names.push_back({lowest[piece.owners[0]], part_in_whole(diagram, piece), piece.island, islands[p]});
    }
    sort_with_polls(execution, names.begin(), names.end());
    unions.push_back(std::move(names));
  }
  std::sort(unions.begin(), unions.end(), [&](const Union& a, const Union& b) {
    pacer.step();
    return a.front() < b.front();
  });
  return unions;
}

std::uint32_t unite_again(const std::vector<Union>& unions, const RestrictedDiagram& diagram,
                          const Pieces& pieces, const std::vector<SiteId>& lowest, PieceGroups& groups,
                          const Execution& execution) {
  Pacer pacer(execution);
  const auto all = pieces.pieces.begin();
  // Returns kNoIndex if the number of islands has changed since the piece was named.
  const auto number = [&](const PieceName& name) {
    pacer.step(64);
    const std::uint32_t owner = owner_of(name.lowest, lowest);
    const auto order = [&](const Piece& piece) {
      return std::pair(piece.owners[0], part_in_whole(diagram, piece));
    };
    const std::pair wanted(owner, name.part);
    const auto begin = std::partition_point(all, pieces.pieces.end(),
                                            [&](const Piece& piece) { return order(piece) < wanted; });
    const auto end = std::partition_point(begin, pieces.pieces.end(),
                                          [&](const Piece& piece) { return order(piece) == wanted; });
    if (end - begin != name.islands) return kNoIndex;
    return static_cast<std::uint32_t>(begin - all) + name.island;
  };
  std::uint32_t united = 0;
  std::vector<std::uint32_t> numbers;
  for (const Union& names : unions) {
    numbers.clear();
    for (const PieceName& name : names) numbers.push_back(number(name));
    std::erase(numbers, kNoIndex);
    for (std::size_t k = 1; k < numbers.size(); ++k, ++united) groups.unite(numbers[0], numbers[k], pacer);
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
