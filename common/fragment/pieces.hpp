// Faces into pieces. Every face of the restricted diagram, piece of input triangle or cap, belongs to the
// *owner* of its cell: the cell itself, or the group of cells that stay together (inside a group bisectors do
// not exist: polygons are fused, caps are not emitted, an exact union at no cost). An owner's faces fall into
// components; each is a piece, except a cavity's shell that no bisector cuts, which joins the piece around
// it.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/clip/restricted_diagram.hpp"

namespace fracture {

/// Which cells stay together.
struct Ownership {
  std::vector<std::uint32_t> owner_of_site;         ///< 0.., numbered by smallest member site
  std::vector<std::vector<SiteId>> sites_of_owner;  ///< ascending
  bool grouped = false;                             ///< some owner has several cells
  std::vector<bool> wanted;  ///< per owner; empty: all. Pieces of the others are not made.
  /// Equal entries stay together; an empty vector means every cell for itself. One entry per site. Throws
  /// Interrupted.
  static Ownership from_groups(std::uint32_t site_count, const std::vector<std::uint32_t>& groups,
                               const Execution& execution = {});
};

/// Where a face comes from: an input triangle (its index), or side 0 (cell lo) or 1 (cell hi) of a cap
/// region.
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
  std::uint32_t part;                 ///< of several that were joined: of the first piece
  /// 0 for the first piece of its owner and part, 1 for the next, …: whatever other cells there are.
  std::uint32_t island;
  std::vector<Face> faces;
  /// The vertices of each member cell's share (also those that fusing hides), for pieces of several cells;
  /// else empty.
  std::vector<std::vector<CutVertexId>> bodies{};
  std::vector<PartOwner>
      part_owners{};  ///< ascending, if pieces of several parts were joined; otherwise empty
};

struct Pieces {
  std::vector<Piece> pieces;                ///< by owner, then part, then their first faces
  std::vector<std::uint32_t> piece_of_cap;  ///< per 2 * region + side; kNoIndex inside a group
};

/// Throws Interrupted.
Pieces gather_pieces(const RestrictedDiagram& diagram, const Ownership& ownership,
                     const Execution& execution);

/// The pieces of the diagram that `flat` are of, after its caps were triangulated finer and moved (rough/refine.hpp): those that
/// gather_pieces() would find, without a further search for what hangs together. Nothing where that may have changed: loops of
/// caps cross, or a region of them has become several, or none. Throws Interrupted.
std::optional<Pieces> with_finer_caps(const Pieces& flat, const RestrictedDiagram& diagram,
                                      const Execution& execution);

/// Signed volume of the closed surface `faces` (divergence theorem), from the unrounded positions, m³.
/// Throws Interrupted.
double signed_volume(const RestrictedDiagram& diagram, const Face* faces, std::size_t count,
                     const Vec3d& origin, const Execution& execution = {});

}  // namespace fracture
