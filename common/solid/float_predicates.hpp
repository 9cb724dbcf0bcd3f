// Exact signs of determinants of float32 coordinates. Evaluates in double with a proven error bound, and
// computes an exact sum only if that is inconclusive.
//
// The products of two floats are exact doubles, and the products of three are exact sums of two doubles. So
// each determinant is a sum of few exact terms. The sign of an exact sum is the sign of the largest component
// of its expansion (Shewchuk 1997, "Adaptive precision floating-point arithmetic and fast robust geometric
// predicates", §2.4 grow-expansion). Range: every finite float32. A zero is exact: the points are coplanar,
// collinear or coincident.
#pragma once

#include <span>
#include <vector>

#include "common/base/vec.hpp"

namespace fracture::solid_detail {

/// An exact running sum of doubles, kept as a non-overlapping expansion without zeros, ascending in
/// magnitude.
class ExactSum {
 public:
  void add(double term);
  void add_product(double exact_product_of_two_floats, float third);
  int sign() const { return parts_.empty() ? 0 : parts_.back() > 0 ? 1 : -1; }
  double estimate() const;

 private:
  std::vector<double> parts_;
};

/// Sign of (b - a) × (c - a): +1 if a, b, c turn counter-clockwise.
int sign_orient2d(const Vec2f& a, const Vec2f& b, const Vec2f& c);

/// Sign of (b - a) · ((c - a) × (d - a)): +1 if d is on the side to which the normal of triangle abc points.
int sign_orient3d(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d);

/// Drops an axis and keeps the result right-handed: dropping x gives (y, z), y gives (z, x), and z gives (x,
/// y).
inline Vec2f drop_axis(const Vec3f& p, int axis) {
  return axis == 0 ? Vec2f{p.y, p.z} : axis == 1 ? Vec2f{p.z, p.x} : Vec2f{p.x, p.y};
}

}  // namespace fracture::solid_detail
