// Checks of a hull: its corners, and that no point of the input lies outside any of its faces.
#pragma once

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/physics/convex_hull.hpp"

namespace fracture::test {

using Points = std::vector<Vec3f>;

/// The largest distance of a point outside a face, in units of the box's longest side.
inline double farthest_outside(const Points& points, const ConvexHullBuilder::Triangles& triangles) {
  Box box;
  for (const Vec3f& p : points) box.add(to_double(p));
  double farthest = 0;
  for (const auto& t : triangles) {
    const Vec3d a = to_double(points[t[0]]), b = to_double(points[t[1]]), c = to_double(points[t[2]]);
    const Vec3d n = cross(b - a, c - a);
    if (length(n) < 1e-4 * box.longest_side() * box.longest_side()) continue;  // only rounding
    for (const Vec3f& p : points) farthest = std::max(farthest, dot(n, to_double(p) - a) / length(n));
  }
  return farthest / box.longest_side();
}

inline Mesh mesh_of(const Points& points, const ConvexHullBuilder::Triangles& triangles) {
  Mesh mesh;
  mesh.positions = points;
  mesh.triangles = triangles;
  return mesh;
}

inline std::set<std::uint32_t> corners(const ConvexHullBuilder::Triangles& triangles) {
  std::set<std::uint32_t> out;
  for (const auto& t : triangles) out.insert(t.begin(), t.end());
  return out;
}

}  // namespace fracture::test
