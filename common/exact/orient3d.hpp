// Decides on which side of the plane abc the point d is: the sign of det[b - a; c - a; d - a]. The result is
// +1 if d is on the side to which (b - a) x (c - a) points, and -1 if it is on the other side. It is 0
// exactly if the four points are coplanar. Coordinates are never perturbed, because that would create flat
// tetrahedra.
//
// Filter (Shewchuk 1997; orient3d_bound() below) -> integers of fixed width if the points fit a BinaryScale
// -> integers of any size. Accepts any finite doubles with |coordinate| <= 1e60, including subnormal ones:
// nothing overflows in the filter, and its bound covers underflow (Meyer & Pion 2008, "FPG: A code generator
// for fast and certified geometric predicates", on semi-static filters).
#pragma once

#include <cmath>

#include "common/base/vec.hpp"
#include "common/exact/approx.hpp"
#include "common/exact/binary_scale.hpp"
#include "common/exact/predicate_counters.hpp"

namespace fracture::exact {

/// `scale` is the scale of a set that contains the four points, or a default-constructed one.
int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const BinaryScale& scale = {},
             PredicateCounters* counters = nullptr);

/// |computed - exact| <= kOrient3dError * |B| |C| |D| + kUnderflow for det[B; C; D] evaluated as in det3()
/// below on the rounded differences B = b - a, ... Derivation, first without underflow: each difference has
/// one rounding, so a product of two has 3, the difference of two products 4, its product with a third
/// difference 6, and the two sums 8. The error is at most gamma_8 times the permanent. By Cauchy-Schwarz,
/// |C_y D_z| + |C_z D_y| <= |C||D|, so the permanent is at most sqrt(3) |B||C||D|. 8 * sqrt(3) * 2^-53 =
/// 13.86 * 2^-53, rounded up to 16 * 2^-53 for the second-order terms and the rounding of the bound itself.
///
/// Underflow: with gradual underflow, sums and differences are exact if they are subnormal. Only products
/// lose something, at most h = 2^-1075. The six inner products of det3() lose 6 h, times an outer difference
/// of at most 2^201 (coordinates of at most 1e60 < 2^200), and the three outer ones lose 3 h. The bound
/// itself, as multiplied in orient3d_bound(), loses h times a length of at most 2^202, plus h. The total is
/// less than 2^-860, whereas kUnderflow is more than 2^-665.
inline constexpr double kOrient3dError = 0x1p-49;
/// Added to squared lengths. A computed |v|^2 is smaller than |v|^2 by a few roundings, which the slack of
/// kOrient3dError covers, and by at most 3 h if the three squares underflow. That can be the whole value: for
/// |v| < 2^-538, the computed square is 0 although v is not. 2^-1000 is far above 3 h, and is a normal double
/// (subnormal operands are slow on some processors).
inline constexpr double kTinySquare = 0x1p-1000;

inline double det3(const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return b.x * (c.y * d.z - c.z * d.y) + b.y * (c.z * d.x - c.x * d.z) + b.z * (c.x * d.y - c.y * d.x);
}

/// The bound for these differences, including underflow: |det3(b, c, d) - exact| is smaller. It is at least
/// kOrient3dError * 2^-500 |C| |D| even if b is tiny, so such determinants are left to the exact path.
inline double orient3d_bound(const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const auto length = [](const Vec3d& v) { return std::sqrt(dot(v, v) + kTinySquare); };
  return kOrient3dError * length(b) * length(c) * length(d) + kUnderflow;
}

}  // namespace fracture::exact
