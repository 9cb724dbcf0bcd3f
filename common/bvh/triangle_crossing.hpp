// Decides whether two triangles cross: whether an edge of one pierces the interior of the other.
#pragma once

#include <array>

#include "common/base/vec.hpp"

namespace fracture {

/// A triangle with its plane.
struct PlaneTriangle {
  std::array<Vec3d, 3> corners;
  Vec3d normal;  ///< unit vector; zero if the triangle is flat, so every height is 0
  explicit PlaneTriangle(const std::array<Vec3d, 3>& t);
};

/// Whether there are corners on both sides of the plane of t, farther away than `tolerance` (m).
bool is_parted(const PlaneTriangle& t, const std::array<Vec3d, 3>& corners, double tolerance);

/// Whether an edge of one triangle pierces the interior of the other, by more than `tolerance` (m) on all
/// sides.
bool cross_each_other(const PlaneTriangle& s, const PlaneTriangle& t, double tolerance);

}  // namespace fracture
