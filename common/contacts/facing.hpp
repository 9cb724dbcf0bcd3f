// How much of one surface faces another one closely.
#pragma once

#include "common/contacts/near_triangles.hpp"

namespace fracture::contacts_detail {

/// Heights over a triangle's plane between which the other surface is near, m.
struct Range {
  double low, high;
};

/// Convex. It has three corners, and one more for each cut: two planes of the range, three sides. More corners arise only
/// from rounding; they almost coincide, so one of them can be left out.
struct Polygon {
  static constexpr std::size_t kMost = 3 + 2 + 3 + 2;
  std::array<Vec3d, kMost> corners;
  int size = 0;
  void push(const Vec3d& p) {
    if (size < static_cast<int>(kMost)) corners[static_cast<std::size_t>(size++)] = p;
  }
  const Vec3d& operator[](int k) const { return corners[static_cast<std::size_t>(k)]; }
};

/// The piece of s that is over t, along the normal of s, at a height in the range; the moment is that on s. 0 if t turns
/// away from s (with `turned_away`: towards s). This is a convex polygon: t, cut to the range and to the prism over s
/// (Sutherland & Hodgman 1974), and projected onto s. `polygon`: the same polygon on t, before the projection.
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
  std::uint32_t first;     ///< of `size` corners on that triangle, m
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

/// Adds to s.faced the part of s from which a ray along the normal of s meets t at a height in the range. Adds the
/// corresponding part of t to t.faced, and the polygons to of_s and of_t. i, k: the numbers of s and t there. Adds nothing if
/// s and t do not face each other: their normals must be about one degree more than a right angle apart, because
/// otherwise rounding could make the walls of a corner face each other.
///
/// The triangles of an embedded surface that face s within the gap do not hide each other unless the surface is thinner
/// than the gap. The sum is limited to the area of s (faced_by()).
void add_facing(NearTriangle& s, std::uint32_t i, FacingPolygons& of_s, NearTriangle& t, std::uint32_t k,
                FacingPolygons& of_t, const Range& range);

/// The share of the faced area that counts.
inline double facing_share(const NearTriangle& t) {
  return t.faced.area > t.area ? t.area / t.faced.area : 1;
}

/// The surface of all these triangles that faces the other part; `outward`: the integral of the normal, m².
struct Faced {
  Patch patch;
  Vec3d outward;
};
Faced faced_by(const std::vector<NearTriangle>& triangles);

}  // namespace fracture::contacts_detail
