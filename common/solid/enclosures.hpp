// Pieces that may be walls rather than bodies: rooms, whose faces look inwards, and pieces that only a large lid closes
// (cloth, terrain, a box without its bottom). Without `thickness` they become bodies, and the report offers walls.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/nesting.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// A lid is large if its area exceeds this share of the area of its piece, which is counted without fills.
inline constexpr double kLargeLid = 0.1;
/// A room has more than this share of the area of the whole surface. Smaller pieces that face inwards are only mistakes
/// of an exporter.
inline constexpr double kRoomShare = 0.1;
/// Share of a piece's longest side that is offered as the thickness of its walls.
inline constexpr double kWallShare = 0.01;

/// Some of the shells, with figures about them.
struct Enclosures {
  std::vector<std::uint8_t> has;  ///< per shell: 1 if it is one; empty: none is
  std::uint64_t count = 0;
  double longest = 0;              ///< m: the longest side of their boxes
  double share = 0;                ///< lids: the largest area, as a share of its piece's
  TriangleId first = kNoTriangle;  ///< of the first room, or of the lid with that share

  bool any() const { return count > 0; }
};

/// Finds the shells that one large fill closes; flat shells have none. `fills`: the first triangle of each filled hole,
/// whose triangles follow each other (the result of fill_holes()).
Enclosures find_large_lids(const Surface& surface, const Shells& shells, const std::vector<TriangleId>& fills,
                           const Execution& execution);

/// Finds the shells that face inwards although nothing encloses them, are large (kRoomShare), and have no large lid.
Enclosures find_rooms(const Shells& shells, const Nesting& nesting, const Enclosures& lids,
                      const Execution& execution);

/// Adds the choice of walls to the report, if there are any such shells.
void offer_walls_of_rooms(const Enclosures& rooms, const Surface& surface, SolidReport& report);
void offer_walls_instead_of_lids(const Enclosures& lids, const Surface& surface, SolidReport& report);

}  // namespace fracture::solid_detail
