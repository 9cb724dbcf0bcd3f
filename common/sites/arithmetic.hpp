// The few transcendental functions that patterns need, computed with + - * / and sqrt, which IEEE 754 rounds
// exactly. The C library's functions differ in their last bits between systems, and snapping to a lattice
// does not remove such differences.
#pragma once

#include "common/base/random.hpp"
#include "common/base/vec.hpp"

namespace fracture::sites_detail {

/// base^exponent for base in [0, 1] and exponent in [0, 64]. Squaring gives the integer part, and repeated
/// square roots the fraction (x^0.b1b2b3… = Π x^(b_k 2^-k)). Accurate to about 1e-12.
double power(double base, double exponent);

/// The natural logarithm of x > 0, to about 1e-15.
double logarithm(double x);

/// (cos, sin) of an angle given in full turns, to about 1e-15.
Vec2d unit_at(double turns);

/// A random direction, uniform on the sphere (by rejection from the cube).
Vec3d random_direction(Random& random);

/// Two unit vectors that make (u, v, axis / |axis|) a right-handed orthonormal frame; axis is not zero.
struct Across {
  Vec3d u, v;
};
Across across(const Vec3d& axis);

Vec3d normalized(const Vec3d& v);

}  // namespace fracture::sites_detail
