// On which side of the plane abc lies d? Sign of det[b - a; c - a; d - a]: +1 when d is on the side to which
// (b - a) x (c - a) points, -1 on the other, and 0 exactly when the four points are coplanar. Zero means
// coplanar: the coordinates are never perturbed (perturbing them makes flat tetrahedra).
//
// Filter (Shewchuk 1997; orient3d_bound() below) -> integers of fixed width where the points fit a
// BinaryScale -> integers of any size. Any finite doubles with |coordinate| <= 1e60 are accepted, subnormal
// ones included: nothing overflows in the filter, and its bound covers underflow (Meyer & Pion 2008, "FPG: A
// code generator for fast and certified geometric predicates", on semi-static filters).
#pragma once

#include <cmath>

#include "common/base/vec.hpp"
#include "common/exact/approx.hpp"
#include "common/exact/binary_scale.hpp"
#include "common/exact/predicate_counters.hpp"

namespace fracture::exact {

/// `scale` is that of a set that contains the four points, or a default-constructed one.
int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const BinaryScale& scale = {},
             PredicateCounters* counters = nullptr);

/// |computed - exact| <= kOrient3dError * |B| |C| |D| + kUnderflow for det[B; C; D] evaluated as in det3()
/// below on the rounded differences B = b - a, ... Derivation, first without underflow. Each difference
/// carries one rounding, so a product of two carries 3, the difference of two products 4, its product with a
/// third difference 6, the two sums 8: the error is at most gamma_8 times the permanent. By Cauchy-Schwarz
/// |C_y D_z| + |C_z D_y| <= |C||D|, hence the permanent is at most sqrt(3) |B||C||D|; 8 * sqrt(3) * 2^-53 =
/// 13.86 * 2^-53, rounded up to 16 * 2^-53 for the second-order terms and the rounding of the bound itself.
///
/// Underflow: with gradual underflow sums and differences are exact where they are subnormal;
/// only a product loses something, at most h = 2^-1075. The six inner products of det3() lose 6 h, times an
/// outer difference of at most 2^201 (coordinates of at most 1e60 < 2^200), and the three outer ones 3 h; the
/// bound itself, as orient3d_bound() multiplies it, loses h times a length of at most 2^202, and h. Together
/// less than 2^-860, where kUnderflow is more than 2^-665.
inline constexpr double kOrient3dError = 0x1p-49;
/// Is added to squared lengths. A computed |v|^2 is smaller than |v|^2 by a few roundings, which the slack of
/// kOrient3dError covers, and by at most 3 h where the three squares underflow, which can be all of it: for
/// |v| < 2^-538 the computed square is 0 although v is not. 2^-1000 is far above 3 h, and a normal double (a
/// subnormal operand would be slow on some processors).
inline constexpr double kTinySquare = 0x1p-1000;

inline double det3(const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return b.x * (c.y * d.z - c.z * d.y) + b.y * (c.z * d.x - c.x * d.z) + b.z * (c.x * d.y - c.y * d.x);
}

/// The bound for these differences, underflow included: |det3(b, c, d) - exact| is smaller. At least
/// kOrient3dError * 2^-500 |C| |D| where b is tiny: such determinants are left to the exact path.
inline double orient3d_bound(const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const auto length = [](const Vec3d& v) { return std::sqrt(dot(v, v) + kTinySquare); };
  return kOrient3dError * length(b) * length(c) * length(d) + kUnderflow;
}

}  // namespace fracture::exact
