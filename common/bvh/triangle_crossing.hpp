// Do two triangles cross? By what makes them: an edge of one that pierces the inside of the other.
#pragma once

#include <array>

#include "common/base/vec.hpp"

namespace fracture {

/// A triangle with its plane.
struct PlaneTriangle {
  std::array<Vec3d, 3> corners;
  Vec3d normal;  ///< unit; zero where the triangle is flat: then every height is 0
  explicit PlaneTriangle(const std::array<Vec3d, 3>& t);
};

/// Are there corners on both sides of the plane of t, by more than `tolerance` (m)?
bool is_parted(const PlaneTriangle& t, const std::array<Vec3d, 3>& corners, double tolerance);

/// Does an edge of one pierce the inside of the other, by more than `tolerance` (m) on all sides?
bool cross_each_other(const PlaneTriangle& s, const PlaneTriangle& t, double tolerance);

}  // namespace fracture
