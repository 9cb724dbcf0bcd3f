#include "common/contacts/moved_signs.hpp"

#include <cmath>

#include "common/exact/orient3d.hpp"
#include "common/solid/float_predicates.hpp"

namespace fracture::contacts_detail {
namespace {

/// Returns the sign of u v' - v u', where u, v, u' and v' are differences of floats.
int cross_sign(double pu, double pv, double qu, double qv, double cu, double cv, double du, double dv) {
  const double left = (qu - pu) * (dv - cv), right = (qv - pv) * (du - cu);
  // Each product has three roundings, and the difference one more (as in solid/float_predicates.cpp).
  const double det = left - right, bound = 4e-16 * (std::fabs(left) + std::fabs(right));
  if (det > bound) return 1;
  if (det < -bound) return -1;
  solid_detail::ExactSum sum;  // products of two floats are exact in doubles
  for (const double term :
       {qu * dv, -(qu * cv), -(pu * dv), pu * cv, -(qv * du), qv * cu, pv * du, -(pv * cu)})
    sum.add(term);
  return sum.sign();
}

/// Returns the first nonzero sign among the components y, z, x of (q - p) x (d - c).
int first_sign_of_cross(const Vec3d& p, const Vec3d& q, const Vec3d& c, const Vec3d& d) {
  if (const int y = cross_sign(p.z, p.x, q.z, q.x, c.z, c.x, d.z, d.x); y != 0) return y;
  if (const int z = cross_sign(p.x, p.y, q.x, q.y, c.x, c.y, d.x, d.y); z != 0) return z;
  return cross_sign(p.y, p.z, q.y, q.z, c.y, c.z, d.y, d.z);
}

}  // namespace

int MovedSigns::side(const Corners& triangle, const Vec3d& p, Owner owner) const {
  const auto& [a, b, c] = triangle;
  if (const int sign = exact::orient3d(a, b, c, p, scale_); sign != 0) return sign;
  const int along = static_cast<int>(owner) * first_sign_of_cross(a, b, a, c);
  return along != 0 ? along : 1;
}

int MovedSigns::passing(const Vec3d& p, const Vec3d& q, const Vec3d& c, const Vec3d& d, Owner owner) const {
  if (const int sign = exact::orient3d(p, q, c, d, scale_); sign != 0) return sign;
  // If p and q move by v relative to c and d, det[q - p; c - p; d - p] grows by v · ((q - p) x (d - c)).
  return static_cast<int>(owner) * first_sign_of_cross(p, q, c, d);
}

int MovedSigns::crossing(const Vec3d& p, const Vec3d& q, const Corners& triangle, Owner owner) const {
  const int from = side(triangle, p, owner), to = side(triangle, q, owner);
  if (from == to) return 0;
  const auto& [a, b, c] = triangle;
  const int ab = passing(p, q, a, b, owner);
  if (ab != passing(p, q, b, c, owner) || ab != passing(p, q, c, a, owner)) return 0;
  return to;
}

bool MovedSigns::coplanar(const Corners& s, const Corners& t) const {
  for (const Vec3d& p : t)
    if (exact::orient3d(s[0], s[1], s[2], p, scale_) != 0) return false;
  return true;
}

bool MovedSigns::moves_outwards(const Corners& triangle) {
  return first_sign_of_cross(triangle[0], triangle[1], triangle[0], triangle[2]) > 0;
}

}  // namespace fracture::contacts_detail
