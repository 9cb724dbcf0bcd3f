// The area of one surface that closely faces another one.
#pragma once

#include "common/contacts/near_triangles.hpp"

namespace fracture::contacts_detail {

/// Range of heights over a triangle's plane, m, in which the other surface counts as near.
struct Range {
  double low, high;
};

/// A convex polygon. It has three corners, plus one for each cut: two planes of the range, three sides.
/// Further corners arise only from rounding. They almost coincide, so one of them can be left out.
struct Polygon {
  static constexpr std::size_t kMost = 3 + 2 + 3 + 2;
  std::array<Vec3d, kMost> corners;
  int size = 0;
  void push(const Vec3d& p) {
    if (size < static_cast<int>(kMost)) corners[static_cast<std::size_t>(size++)] = p;
  }
  const Vec3d& operator[](int k) const { return corners[static_cast<std::size_t>(k)]; }
};

/// Returns the part of s that is over t along the normal of s, at a height in the range. The moment is
/// computed on s. The area is 0 if t faces away from s (with `turned_away`: if t faces s). The part is a
/// convex polygon: t is cut to the range and to the prism over s (Sutherland & Hodgman 1974), and projected
/// onto s. `polygon`: the same polygon on t, before the projection.
Patch part_over(const NearTriangle& s, const NearTriangle& t, const Range& range, bool turned_away,
                Polygon& polygon);
inline Patch part_over(const NearTriangle& s, const NearTriangle& t, const Range& range,
                       bool turned_away = false) {
  Polygon polygon;
  return part_over(s, t, range, turned_away, polygon);
}

/// Surface of a triangle that faces the other part.
struct FacingPolygon {
  std::uint32_t triangle;  ///< in NearPair::a or b
  std::uint32_t first;     ///< index of the first of its `size` corners, which lie on that triangle
  std::uint32_t size;
  double area;    ///< m²
  double height;  ///< m: mean height of the other surface over the corners
};
struct FacingPolygons {
  std::vector<FacingPolygon> polygons;
  std::vector<Vec3d> corners;
  void clear() {
    polygons.clear();
    corners.clear();
  }
};

/// Adds to s.faced the part of s from which a ray along the normal of s meets t at a height in the range.
/// Adds the corresponding part of t to t.faced, and the polygons to of_s and of_t. i and k are the numbers
/// of s and t in these. Adds nothing if s and t do not face each other. Their normals must differ by about
/// one degree more than a right angle, because otherwise rounding could make the walls of a corner face
/// each other.
///
/// The triangles of an embedded surface that face s within the gap do not hide each other, unless the
/// surface is thinner than the gap. The sum is limited to the area of s (faced_by()).
void add_facing(NearTriangle& s, std::uint32_t i, FacingPolygons& of_s, NearTriangle& t, std::uint32_t k,
                FacingPolygons& of_t, const Range& range);

/// Returns the share of the faced area that counts.
inline double facing_share(const NearTriangle& t) {
  return t.faced.area > t.area ? t.area / t.faced.area : 1;
}

/// The surface of all triangles that faces the other part. `outward`: the integral of the normal, m².
struct Faced {
  Patch patch;
  Vec3d outward;
};
Faced faced_by(const std::vector<NearTriangle>& triangles);

}  // namespace fracture::contacts_detail
