// A 3×3 matrix of doubles, with only the operations that linear maps of space need.
#pragma once

#include <array>
#include <cmath>

#include "common/base/vec.hpp"

namespace fracture {

struct Matrix3 {
  std::array<Vec3d, 3> rows{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  friend bool operator==(const Matrix3&, const Matrix3&) = default;

  Vec3d operator*(const Vec3d& v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
  /// Multiplies v by the transposed matrix, which transforms normals back through the map.
  Vec3d transposed_times(const Vec3d& v) const {
    return {rows[0].x * v.x + rows[1].x * v.y + rows[2].x * v.z,
            rows[0].y * v.x + rows[1].y * v.y + rows[2].y * v.z,
            rows[0].z * v.x + rows[1].z * v.y + rows[2].z * v.z};
  }
  double determinant() const { return dot(rows[0], cross(rows[1], rows[2])); }
  /// |determinant| / product of the rows' lengths: 1 for orthogonal rows, 0 for dependent ones.
  double conditioning() const {
    const double lengths = length(rows[0]) * length(rows[1]) * length(rows[2]);
    return lengths > 0 ? std::fabs(determinant()) / lengths : 0;
  }
  /// Computed from cofactors; the determinant must not be zero.
  Matrix3 inverse() const {
    const double scale = 1 / determinant();
    const Vec3d a = cross(rows[1], rows[2]), b = cross(rows[2], rows[0]), c = cross(rows[0], rows[1]);
    return {{Vec3d{scale * a.x, scale * b.x, scale * c.x}, Vec3d{scale * a.y, scale * b.y, scale * c.y},
             Vec3d{scale * a.z, scale * b.z, scale * c.z}}};
  }
  Matrix3 operator-() const { return {{-1.0 * rows[0], -1.0 * rows[1], -1.0 * rows[2]}}; }
};

}  // namespace fracture
