// The sphere through the corners of a tetrahedron, with a margin that covers all rounding errors: the filter
// of in_sphere. Works on one tetrahedron (T = double) or on two at a time (T = Two), with the same operations
// for each.
#pragma once

#include <cmath>

#include "common/base/vec.hpp"
#include "common/exact/binary_scale.hpp"

namespace fracture::delaunay_detail {

/// Two doubles in one register, for both g++ and clang.
using Two = double __attribute__((vector_size(16)));

/// The vector from corner 0 to another corner, in the units of the sites. Each component has one rounding.
template <class T>
struct Edge {
  exact::Point<T> to;
  T lift;  ///< squared length
};

/// In units of K, about the centre of the big tetrahedron.
template <class T>
struct Circumsphere {
  exact::Point<T> center;
  T radius2;  ///< NaN if errors may exceed the margin
};

/// A point is certainly inside or outside if its squared distance from the centre differs from radius2 by
/// more than this share of radius2. circumsphere() derives that 2^-22 is enough, and rounding radius2 to a
/// float adds 2^-24.
inline constexpr double kMargin = 0x1p-21;

/// corner0: normalized; scale: 1 / K. The centre, relative to corner 0, is
///   n / (2 delta),  n = |b|^2 (c x d) + |c|^2 (d x b) + |d|^2 (b x c),  delta = b · (c x d).
/// Errors, with u = 2^-53: let B, C, D be the lengths of b, c, d. Let R be the radius; so B, C, D <= 2 R. b,
/// c, d have one rounding each. The error of a component of n is at most
///   12u BCD (B + C + D) <= 73u BCD R,
/// and the error of delta is at most 8u sqrt(3) BCD <= 14u BCD. The function requires delta >= 2^-20 BCD.
/// Then the error of a component of n / (2 delta) is at most:
///
///   (73u BCD R / 2 + 14u BCD R) / delta + 2u R  <=  51u 2^20 R + 2u R  <  2^-27 R.
/// In units of K, the error of a site is u, so the centre gets another u (3 + 2 R). The function also
/// requires R >= 2^-22. The vector from the centre to any site then has an error of at most this length:
///
///   e = sqrt(3) (2^-27 R + u (4 + 2 R)) < 2^-25 R.
/// Let r be the distance of a site from the true centre. The error of the compared difference of squares is
/// at most
///   2e (r + R) + 2e^2 + 6u (r^2 + R^2).
/// This is less than 2^-22 R^2 if r <= 2 R. If r is larger, the site is outside, and the result says so,
/// because r^2 - 2er is far above R^2.
/// 1e-250 excludes underflow: no length exceeds 2^46 (kMaxSiteCoordinate). So a lift that underflows changes
/// the product of the three by less than 2^-1074 2^184 < 1e-267.
template <class T>
Circumsphere<T> circumsphere(const Vec3d& corner0, double scale, const Edge<T>& b, const Edge<T>& c,
                             const Edge<T>& d) {
  constexpr double kLeastVolume2 = 0x1p-40, kLeastRadius2 = 0x1p-44;
  const exact::Point<T> cd = cross(c.to, d.to), db = cross(d.to, b.to), bc = cross(b.to, c.to);
  const T delta = dot(b.to, cd);
  const T factor = 0.5 * scale / delta;
  const T x = corner0.x + factor * (b.lift * cd.x + c.lift * db.x + d.lift * bc.x);
  const T y = corner0.y + factor * (b.lift * cd.y + c.lift * db.y + d.lift * bc.y);
  const T z = corner0.z + factor * (b.lift * cd.z + c.lift * db.z + d.lift * bc.z);
  const exact::Point<T> radius{x - corner0.x, y - corner0.y, z - corner0.z};
  const T radius2 = dot(radius, radius);
  const auto good =
      (delta * delta > kLeastVolume2 * (b.lift * c.lift * d.lift) + 1e-250) & (radius2 > kLeastRadius2);
  return {{x, y, z}, good ? radius2 : T{} + NAN};
}

}  // namespace fracture::delaunay_detail
