// Rotation, uniform scale and translation: the transforms under which convex hulls, spheres and mass properties keep their kind.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "common/base/vec.hpp"

namespace fracture {

/// Unit quaternion x, y, z, w.
using Quaternion = std::array<double, 4>;

/// Rotates v by a unit quaternion.
inline Vec3d rotated(const Quaternion& q, const Vec3d& v) {
  const Vec3d axis{q[0], q[1], q[2]};
  const Vec3d twice = 2.0 * cross(axis, v);
  return v + q[3] * twice + cross(axis, twice);
}

inline Quaternion inverse(const Quaternion& q) { return {-q[0], -q[1], -q[2], q[3]}; }

/// Rotates by `b` first, then by `a`.
inline Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
          a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
          a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

struct Similarity {
  Quaternion rotation{0, 0, 0, 1};
  double scale = 1;  ///< > 0
  Vec3d move;        ///< m, after rotation and scale

  Vec3d linear(const Vec3d& v) const { return scale * rotated(rotation, v); }
  Vec3d point(const Vec3d& p) const { return linear(p) + move; }
  Vec3d unmoved(const Vec3d& p) const { return (1 / scale) * rotated(fracture::inverse(rotation), p - move); }
};

/// Applies `b` first, then the inverse of `a`.
inline Similarity after_inverse(const Similarity& a, const Similarity& b) {
  const Quaternion back = inverse(a.rotation);
  return {product(back, b.rotation), b.scale / a.scale, a.unmoved(b.move)};
}

/// Returns the similarity with these columns of its linear part, up to `tolerance` relative to its scale. Returns nothing if the
/// linear part mirrors, shears or scales axes differently. Quaternion: Shepperd, Quaternion from Rotation Matrix (1978).
inline std::optional<Similarity> similarity_of(const Vec3d& x, const Vec3d& y, const Vec3d& z,
                                               const Vec3d& move, double tolerance) {
  const double square = (dot(x, x) + dot(y, y) + dot(z, z)) / 3;
  if (!(square > 0) || !std::isfinite(square) || !std::isfinite(move.x + move.y + move.z))
    return std::nullopt;
  for (const double off :
       {dot(x, x) - square, dot(y, y) - square, dot(z, z) - square, dot(x, y), dot(y, z), dot(z, x)})
    if (!(std::fabs(off) <= tolerance * square)) return std::nullopt;
  if (!(dot(x, cross(y, z)) > 0)) return std::nullopt;
  const double scale = std::sqrt(square);
  const Vec3d a = (1 / scale) * x, b = (1 / scale) * y, c = (1 / scale) * z;
  const double trace = a.x + b.y + c.z;
  Quaternion q{};
  if (trace >= a.x && trace >= b.y && trace >= c.z)
    q = {b.z - c.y, c.x - a.z, a.y - b.x, 1 + trace};
  else if (a.x >= b.y && a.x >= c.z)
    q = {1 + 2 * a.x - trace, a.y + b.x, c.x + a.z, b.z - c.y};
  else if (b.y >= c.z)
    q = {a.y + b.x, 1 + 2 * b.y - trace, b.z + c.y, c.x - a.z};
  else
    q = {c.x + a.z, b.z + c.y, 1 + 2 * c.z - trace, a.y - b.x};
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& k : q) k /= norm;
  if (q[3] < 0)
    for (double& k : q) k = 0 - k;
  return Similarity{q, scale, move};
}

}  // namespace fracture
