// Who touches a group of pieces, and by how much, while groups grow.
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
  double area;  ///< m², of the caps between them, summed in their order (cap_area.hpp)
};

/// Knows the caps between groups for the groups that were asked about, and keeps them up to date: a union
/// moves the caps of the smaller set (piece_groups.hpp), so that a group that grows piece by piece costs its
/// caps and not its caps as often as it grows.
class GroupContacts {
 public:
  /// All are borrowed; `groups` changes by unite() alone from now on.
  GroupContacts(const RestrictedDiagram& diagram, const Pieces& pieces, PieceGroups& groups,
                const Execution& execution);

  /// Largest area first, ties by the lowest name. Throws Interrupted.
  std::vector<Neighbor> neighbors(std::uint32_t group);
  /// Unites the groups of these pieces, here and in `groups`. Throws Interrupted.
  void unite(std::uint32_t a, std::uint32_t b);
  /// Gives the memory back. Nothing may follow. Throws Interrupted.
  void release();

 private:
  struct Shared {
    std::vector<std::uint32_t> regions;  ///< ascending
    double area = 0;
  };
  using Neighbors = std::unordered_map<std::uint32_t, Shared>;  ///< by set; order never shows

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
