#include "common/sites/arithmetic.hpp"

#include <cmath>

namespace fracture::sites_detail {

double power(double base, double exponent) {
  if (base <= 0) return exponent > 0 ? 0 : 1;
  const auto whole = static_cast<int>(exponent);
  double result = 1;
  double square = base;
  for (int k = whole; k > 0; k >>= 1) {
    if (k & 1) result *= square;
    square *= square;
  }
  double fraction = exponent - whole, root = base;
  for (int bit = 0; bit < 44 && fraction > 0; ++bit) {
    root = std::sqrt(root);
    fraction *= 2;
    if (fraction >= 1) {
      result *= root;
      fraction -= 1;
    }
  }
  return result;
}

double logarithm(double x) {
  constexpr double kLogTwo = 0.693147180559945309417;
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);  // exact, in [1/2, 1)
  if (mantissa < 0.70710678) {
    mantissa *= 2;
    --exponent;
  }
  // ln m = 2 artanh(s). Because |s| < 0.18, thirteen terms are accurate to 1e-19.
  const double s = (mantissa - 1) / (mantissa + 1), s2 = s * s;
  double sum = 0;
  for (int k = 12; k >= 0; --k) sum = sum * s2 + 1.0 / (2 * k + 1);
  return exponent * kLogTwo + 2 * s * sum;
}

Vec2d unit_at(double turns) {
  const double eighth = std::floor(8 * (turns - std::floor(turns)) + 0.5);
  constexpr double kTwoPi = 6.283185307179586476925;
  // Within a sixteenth of a turn, the Taylor series of degree 17 is accurate to 1e-19.
  const double x = kTwoPi * (turns - std::floor(turns) - eighth / 8), x2 = x * x;
  double c = 0, s = 0;
  for (int k = 8; k >= 1; --k) {
    c = -(1 + c) * x2 / static_cast<double>((2 * k - 1) * (2 * k));
    s = -(1 + s) * x2 / static_cast<double>(2 * k * (2 * k + 1));
  }
  c = 1 + c;
  s = x * (1 + s);
  const double h = std::sqrt(0.5);
  switch (static_cast<int>(eighth) % 8) {
    case 0:
      return {c, s};
    case 1:
      return {h * (c - s), h * (c + s)};
    case 2:
      return {-s, c};
    case 3:
      return {-h * (c + s), h * (c - s)};
    case 4:
      return {-c, -s};
    case 5:
      return {h * (s - c), -h * (c + s)};
    case 6:
      return {s, -c};
    default:
      return {h * (c + s), h * (s - c)};
  }
}

Vec3d random_direction(Random& random) {
  for (;;) {
    Vec3d d;
    for (int a = 0; a < 3; ++a) d[a] = 2 * random.uniform() - 1;
    const double square = dot(d, d);
    if (square <= 1 && square > 1e-6) return (1 / std::sqrt(square)) * d;
  }
}

Vec3d normalized(const Vec3d& v) {
  // Scale first, so that no square overflows or underflows.
  const double largest = std::fmax(std::fabs(v.x), std::fmax(std::fabs(v.y), std::fabs(v.z)));
  const Vec3d scaled{v.x / largest, v.y / largest, v.z / largest};
  const double l = length(scaled);
  return {scaled.x / l, scaled.y / l, scaled.z / l};
}

Across across(const Vec3d& axis) {
  const Vec3d n = normalized(axis);
  int least = 0;
  for (int a = 1; a < 3; ++a)
    if (std::fabs(n[a]) < std::fabs(n[least])) least = a;
  Vec3d e;
  e[least] = 1;
  const Vec3d u = normalized(e - dot(e, n) * n);
  return {u, cross(n, u)};
}

}  // namespace fracture::sites_detail
