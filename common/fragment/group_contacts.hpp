// Neighbours of a group of pieces and their contact areas, while groups grow.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/piece_groups.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

struct Neighbor {
  std::uint32_t group;
  double area;  ///< m², of the caps between them, summed in region order (cap_area.hpp)
};

/// Keeps the caps between groups up to date, for groups that were asked about. A union moves only the caps
/// of the smaller set (piece_groups.hpp). So if a group grows piece by piece, its caps are not visited
/// again at each step.
class GroupContacts {
 public:
  /// All arguments are borrowed. From now on, only unite() may change `groups`.
  GroupContacts(const RestrictedDiagram& diagram, const Pieces& pieces, PieceGroups& groups,
                const Execution& execution);

  /// Returns the neighbours of a group, largest area first; ties by the lowest name. Throws Interrupted.
  std::vector<Neighbor> neighbors(std::uint32_t group);
  /// Unites the groups of these pieces, here and in `groups`. Throws Interrupted.
  void unite(std::uint32_t a, std::uint32_t b);
  /// Frees the memory. No other call may follow. Throws Interrupted.
  void release();

 private:
  struct Shared {
    std::vector<std::uint32_t> regions;  ///< ascending
    double area = 0;
  };
  using Neighbors = std::unordered_map<std::uint32_t, Shared>;  ///< by set; no result depends on its order

  Neighbors& known(std::uint32_t set);
  double area_of(const std::vector<std::uint32_t>& regions);
  void measure(Shared& shared) { shared.area = area_of(shared.regions); }

  const RestrictedDiagram& d_;
  const Pieces& pieces_;
  PieceGroups& groups_;
  const Execution& execution_;
  Pacer pacer_;
  std::unordered_map<std::uint32_t, Neighbors> known_;  ///< by set
};

}  // namespace fracture
