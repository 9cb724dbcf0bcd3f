// The sphere through the corners of a tetrahedron, with a margin that covers all rounding: the filter of in_sphere.
// For one tetrahedron (T = double) or for two at a time (T = Two), the same operations for each.
#pragma once

#include <cmath>

#include "common/base/vec.hpp"
#include "common/exact/binary_scale.hpp"

namespace fracture::delaunay_detail {

/// Two doubles in one register, of g++ and clang alike.
using Two = double __attribute__((vector_size(16)));

/// From corner 0 to another one, in the units of the sites, each component with one rounding.
template <class T>
struct Edge {
  exact::Point<T> to;
  T lift;  ///< squared length
};

/// In units of K about the centre of the big tetrahedron.
template <class T>
struct Circumsphere {
  exact::Point<T> center;
  T radius2;  ///< NaN where errors may exceed the margin
};

/// A point is inside or outside for certain where its squared distance from the centre differs from radius2, even as a
/// float, by more than this share of it: circumsphere() shows 2^-22 to be enough, and rounding to a float takes 2^-24.
inline constexpr double kMargin = 0x1p-21;

/// corner0: normalized; scale: 1 / K. The centre is, from corner 0,
///   n / (2 delta),  n = |b|^2 (c x d) + |c|^2 (d x b) + |d|^2 (b x c),  delta = b · (c x d).
/// Errors, with u = 2^-53; B, C, D the lengths of b, c, d; R the radius, so that B, C, D <= 2 R. b, c, d have one rounding
/// each: a component of n is wrong by at most 12u BCD (B + C + D) <= 73u BCD R, delta by 8u sqrt(3) BCD <= 14u BCD.
/// Where delta >= 2^-20 BCD, a component of n / (2 delta) is then wrong by at most
///   (73u BCD R / 2 + 14u BCD R) / delta + 2u R  <=  51u 2^20 R + 2u R  <  2^-27 R.
/// In units of K a site is wrong by u, hence the centre by another u (3 + 2 R). Where R >= 2^-22 too, the vector from the
/// centre to any site has an error of length at most e = sqrt(3) (2^-27 R + u (4 + 2 R)) < 2^-25 R. With r the distance
/// of a site from the true centre, the difference of the squares that are compared is wrong by at most
/// 2e (r + R) + 2e^2 + 6u (r^2 + R^2): less than 2^-22 R^2 where r <= 2 R. Where r is more, the site is outside, and
/// is found there, for r^2 - 2er is far above R^2.
/// 1e-250 keeps underflow out: no length exceeds 2^46 (kMaxSiteCoordinate), so that a lift that underflows changes the
/// product of the three by less than 2^-1074 2^184 < 1e-267.
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
