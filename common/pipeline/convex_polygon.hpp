// Convex polygons in space, clipped by half-spaces.
#pragma once

#include <vector>

#include "common/base/vec.hpp"

namespace fracture {

using ConvexPolygon = std::vector<Vec3d>;

/// Keeps the part of the polygon with normal · x <= offset. `scratch`: memory that calls share.
inline void clip(ConvexPolygon& polygon, const Vec3d& normal, double offset, ConvexPolygon& scratch) {
  scratch.clear();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const double da = dot(normal, a) - offset, db = dot(normal, b) - offset;
    if (da <= 0) scratch.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) scratch.push_back(a + (da / (da - db)) * (b - a));
  }
  polygon.swap(scratch);
}

/// Keeps the part in the box.
inline void clip(ConvexPolygon& polygon, const Box& box, ConvexPolygon& scratch) {
  for (int a = 0; a < 3 && !polygon.empty(); ++a) {
    Vec3d normal;
    normal[a] = 1;
    clip(polygon, normal, box.max[a], scratch);
    clip(polygon, -1.0 * normal, -box.min[a], scratch);
  }
}

/// A square in the plane of these points, with the given middle and half of its side.
inline ConvexPolygon square(const Vec3d& middle, const Vec3d& s, const Vec3d& t, double half) {
  return {middle - half * s - half * t, middle + half * s - half * t, middle + half * s + half * t,
          middle - half * s + half * t};
}

}  // namespace fracture
