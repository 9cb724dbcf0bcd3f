// The few transcendental functions that patterns need, from + - * / and sqrt, which IEEE 754 rounds exactly:
// the C library's own differ in their last bits between systems, and no snapping to a lattice mends that.
#pragma once

#include "common/base/random.hpp"
#include "common/base/vec.hpp"

namespace fracture::sites_detail {

/// base^exponent for base in [0, 1] and exponent in [0, 64]: the whole part by squaring, the fraction by
/// repeated square roots (x^0.b1b2b3… = Π x^(b_k 2^-k)). Good to about 1e-12.
double power(double base, double exponent);

/// The natural logarithm of x > 0, to about 1e-15.
double logarithm(double x);

/// (cos, sin) of a number of full turns, to about 1e-15.
Vec2d unit_at(double turns);

/// A direction uniform on the sphere (rejection from the cube).
Vec3d random_direction(Random& random);

/// Two unit vectors that make (u, v, axis / |axis|) a right-handed orthonormal frame; axis is not zero.
struct Across {
  Vec3d u, v;
};
Across across(const Vec3d& axis);

Vec3d normalized(const Vec3d& v);

}  // namespace fracture::sites_detail
