// Collects faces into pieces. Every face of the restricted diagram, part of an input triangle or of a cap,
// belongs to the *owner* of its cell: the cell itself, or the group of cells that stay together. Inside a
// group, there are no bisectors: polygons are fused and caps are not emitted, which is an exact union at no
// cost. An owner's faces form connected components. Each component is a piece, except the shell of a cavity
// that no bisector cuts, which joins the piece around it.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/clip/restricted_diagram.hpp"

namespace fracture {

/// Assigns cells to owners; the cells of one owner stay together.
struct Ownership {
  std::vector<std::uint32_t> owner_of_site;         ///< numbered from 0, by smallest member site
  std::vector<std::vector<SiteId>> sites_of_owner;  ///< ascending
  bool grouped = false;                             ///< whether some owner has several cells
  std::vector<bool> wanted;  ///< per owner; if empty, all. Pieces of the other owners are not made.
  /// Cells with equal entries in `groups` (one per site) stay together. If `groups` is empty, each cell is
  /// an owner of its own. Throws Interrupted.
  static Ownership from_groups(std::uint32_t site_count, const std::vector<std::uint32_t>& groups,
                               const Execution& execution = {});
};

/// Source of a face: an input triangle (its index), or side 0 (cell lo) or 1 (cell hi) of a cap region.
using FaceSource = std::uint32_t;
inline constexpr FaceSource kCapFace = 0x80000000u;
inline FaceSource cap_source(std::uint32_t region, int side) {
  return kCapFace | (2 * region + static_cast<FaceSource>(side));
}
inline bool is_cap(FaceSource s) { return s & kCapFace; }
inline std::uint32_t cap_region(FaceSource s) { return (s & ~kCapFace) / 2; }
inline int cap_side(FaceSource s) { return static_cast<int>(s & 1); }

struct Face {
  std::array<CutVertexId, 3> v;  ///< counter-clockwise from outside the piece
  FaceSource source;
};

/// An owner's share of a part.
struct PartOwner {
  std::uint32_t part, owner;
  auto operator<=>(const PartOwner&) const = default;
};

struct Piece {
  std::vector<std::uint32_t> owners;  ///< ascending; several after uniting
  std::uint32_t part;                 ///< if pieces of several parts were joined, that of the first piece
  /// 0 for the first piece of its owner and part, 1 for the next, and so on. Does not depend on other
  /// cells.
  std::uint32_t island;
  std::vector<Face> faces;
  /// The vertices of each member cell's share, including those that fusing hides, for pieces of several
  /// cells; otherwise empty.
  std::vector<std::vector<CutVertexId>> bodies{};
  /// Ascending, if pieces of different parts were joined; otherwise empty
  std::vector<PartOwner> part_owners{};
};

struct Pieces {
  std::vector<Piece> pieces;                ///< sorted by owner, then by part, then by their first faces
  std::vector<std::uint32_t> piece_of_cap;  ///< per 2 * region + side; kNoIndex inside a group
};

/// Finds the pieces of the wanted owners. Throws Interrupted.
Pieces gather_pieces(const RestrictedDiagram& diagram, const Ownership& ownership,
                     const Execution& execution);

/// Returns the pieces of a diagram after its caps were triangulated more finely and moved
/// (rough/refine.hpp). `flat`: its pieces before. The result equals that of gather_pieces(), without
/// another search for connected components. Returns nothing if the components may have changed: loops of
/// caps cross, or a cap region split or vanished. Throws Interrupted.
std::optional<Pieces> with_finer_caps(const Pieces& flat, const RestrictedDiagram& diagram,
                                      const Execution& execution);

/// Signed volume of the closed surface `faces` (divergence theorem), from the unrounded positions, m³.
/// Throws Interrupted.
double signed_volume(const RestrictedDiagram& diagram, const Face* faces, std::size_t count,
                     const Vec3d& origin, const Execution& execution = {});

}  // namespace fracture
