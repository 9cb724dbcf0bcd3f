// On which side of the plane abc lies d? Sign of det[b - a; c - a; d - a]: +1 when d is on the side to which
// (b - a) x (c - a) points, -1 on the other, and 0 exactly when the four points are coplanar. Zero means
// coplanar: the coordinates are never perturbed (perturbing them makes flat tetrahedra).
//
// Filter (one static bound, derived in the .cpp) -> integers of fixed width where the points fit a PointScale
// -> integers of any size. Any finite doubles with |coordinate| <= 1e60 are accepted (no overflow in the
// filter).
#pragma once

#include <cmath>

#include "common/base/vec.hpp"
#include "common/exact/wide_int.hpp"

namespace fracture::exact {

int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

/// The same without the filter, for callers that have evaluated their own. `scale` is that of a set that
/// contains the four points, or a default-constructed one.
int orient3d_exact(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const PointScale& scale,
                   PredicateCounters* counters = nullptr);

/// Sign of det[b; c; d] for exact differences, all below 2^62 in magnitude.
int orient3d_sign(const IntPoint& b, const IntPoint& c, const IntPoint& d);

/// |computed - exact| <= kOrient3dError * |B| |C| |D| for det[B; C; D] evaluated as in det3() below on the
/// rounded differences B = b - a, ..., plus kUnderflow. Derivation. Each difference carries one rounding, so
/// a product of two carries 3, the difference of two products 4, its product with a third difference 6, the
/// two sums 8: the error is at most gamma_8 times the permanent. By Cauchy-Schwarz |C_y D_z| + |C_z D_y| <=
/// |C||D|, hence the permanent is at most sqrt(3) |B||C||D|; 8 * sqrt(3) * 2^-53 = 13.86 * 2^-53, rounded up
/// to 16 * 2^-53 for the second-order terms and the rounding of the bound itself.
inline constexpr double kOrient3dError = 0x1p-49;
/// Covers what underflow may add: a few dozen operations lose 2^-1074 each, times one coordinate of at most
/// 1e60 where the others are so small that the relative bound vanishes.
inline constexpr double kUnderflow = 1e-200;

inline double det3(const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return b.x * (c.y * d.z - c.z * d.y) + b.y * (c.z * d.x - c.x * d.z) + b.z * (c.x * d.y - c.y * d.x);
}

}  // namespace fracture::exact
