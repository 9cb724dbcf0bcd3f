// Exact tests between two parts: on which side of a triangle a point of the other part is, and whether an
// edge goes through the triangle. The result is never "on it".
//
// Part a is treated as if it were moved by (ε³, ε, ε²) with an infinitesimal ε > 0 (simulation of
// simplicity, Edelsbrunner & Mücke 1990, with one translation for all points of a part). The moved parts
// touch nowhere. Each edge passes through the inside of a triangle or past it. The segments in which
// triangles cross form closed loops, and a vertex is either inside a part or outside. The translation
// separates coplanar faces of both parts: toward +y, then +z, then +x.
//
// Signs are those of exact determinants (exact/orient3d.hpp). If a determinant is 0, its derivative along
// the translation decides: a component of a cross product, in the order y, z, x.
#pragma once

#include <array>

#include "common/base/vec.hpp"
#include "common/exact/binary_scale.hpp"

namespace fracture::contacts_detail {

using Corners = std::array<Vec3d, 3>;

/// The part that a point or an edge belongs to. The value is the sign of its movement relative to the other
/// part.
enum class Owner : int { kA = 1, kB = -1 };
inline Owner other(Owner owner) { return owner == Owner::kA ? Owner::kB : Owner::kA; }

class MovedSigns {
 public:
  /// Registers points, which makes their exact signs faster. Coordinates are floats.
  void include(const Corners& corners) {
    for (const Vec3d& p : corners) scale_.include(p);
  }

  /// Returns +1 if p, which belongs to the owner, is on the side of the triangle to which its normal
  /// points, otherwise -1. Always +1 if the triangle has no area: its corners are on a line, so nothing
  /// crosses it.
  int side(const Corners& triangle, const Vec3d& p, Owner owner) const;
  /// Returns how the owner's edge from p to q passes the other part's edge from c to d: the sign of det[q -
  /// p; c - p; d - p]. It is 0 only if the edges are parallel. An edge with its ends on two sides of a
  /// triangle is not parallel to any of the triangle's edges.
  int passing(const Vec3d& p, const Vec3d& q, const Vec3d& c, const Vec3d& d, Owner owner) const;
  /// Returns how the owner's edge from p to q goes through a triangle of the other part: -1 from outside to
  /// inside, +1 from inside to outside, 0 if it does not.
  int crossing(const Vec3d& p, const Vec3d& q, const Corners& triangle, Owner owner) const;

  /// Whether two triangles are exactly in one plane.
  bool coplanar(const Corners& s, const Corners& t) const;
  /// Whether the translation of part a moves a triangle of a with this plane outwards.
  static bool moves_outwards(const Corners& triangle);

 private:
  exact::BinaryScale scale_;
};

}  // namespace fracture::contacts_detail
