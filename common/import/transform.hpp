// Affine transforms of scene graphs, in double. A transform that is exactly the identity keeps every bit
// (even the sign of zero), so a file whose nodes have no effect keeps its coordinates.
#pragma once

#include <array>
#include <cmath>

#include "common/base/vec.hpp"

namespace fracture {

struct Transform {
  /// The columns of the linear part, and the translation.
  Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, t{0, 0, 0};
  friend bool operator==(const Transform&, const Transform&) = default;

  Vec3d linear(const Vec3d& v) const {
    return {x.x * v.x + y.x * v.y + z.x * v.z, x.y * v.x + y.y * v.y + z.y * v.z,
            x.z * v.x + y.z * v.y + z.z * v.z};
  }
  Vec3d point(const Vec3d& p) const { return linear(p) + t; }
  /// Transforms a normal, up to a positive factor. The cofactor matrix is det times the inverse transpose,
  /// and the sign of det is removed.
  Vec3d normal(const Vec3d& n) const {
    const Vec3d c = n.x * cross(y, z) + n.y * cross(z, x) + n.z * cross(x, y);
    return determinant() < 0 ? -1.0 * c : c;
  }
  double determinant() const { return dot(x, cross(y, z)); }
};

/// Applies `b` first, then `a`.
inline Transform operator*(const Transform& a, const Transform& b) {
  return {a.linear(b.x), a.linear(b.y), a.linear(b.z), a.point(b.t)};
}

/// Translation · rotation (quaternion x, y, z, w; normalised here) · scale.
inline Transform compose(const Vec3d& t, const std::array<double, 4>& quaternion, const Vec3d& s) {
  const double norm = std::sqrt(quaternion[0] * quaternion[0] + quaternion[1] * quaternion[1] +
                                quaternion[2] * quaternion[2] + quaternion[3] * quaternion[3]);
  std::array<double, 4> q = quaternion;
  if (norm > 0 && norm != 1)
    for (double& c : q) c /= norm;
  if (!(norm > 0)) q = {0, 0, 0, 1};
  const double xx = q[0] * q[0], yy = q[1] * q[1], zz = q[2] * q[2], xy = q[0] * q[1], xz = q[0] * q[2],
               yz = q[1] * q[2], wx = q[3] * q[0], wy = q[3] * q[1], wz = q[3] * q[2];
  return {s.x * Vec3d{1 - 2 * (yy + zz), 2 * (xy + wz), 2 * (xz - wy)},
          s.y * Vec3d{2 * (xy - wz), 1 - 2 * (xx + zz), 2 * (yz + wx)},
          s.z * Vec3d{2 * (xz + wy), 2 * (yz - wx), 1 - 2 * (xx + yy)}, t};
}

/// The unit vector, rounded once to float; zero if the length is zero or not finite.
inline Vec3f unit_float(const Vec3d& v) {
  const double l = length(v);
  if (!(l > 0) || !std::isfinite(l)) return {};
  return {static_cast<float>(v.x / l), static_cast<float>(v.y / l), static_cast<float>(v.z / l)};
}

inline Vec3f to_float(const Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace fracture
