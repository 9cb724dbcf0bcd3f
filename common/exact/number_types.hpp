// Integers for the exact path: every coordinate is a double, hence an integer multiple of a power of two;
// scaled by the smallest such power of all coordinates involved, a polynomial's sign is an integer
// computation without rounding.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "common/base/vec.hpp"

namespace fracture::exact {

/// Fixed capacity, no allocation: enough for degree-9 polynomials in coordinates that span 100 bits.
using FixedInt = boost::multiprecision::number<
    boost::multiprecision::cpp_int_backend<1024, 1024, boost::multiprecision::signed_magnitude,
                                           boost::multiprecision::unchecked, void>,
    boost::multiprecision::et_off>;
/// Any size: float32 coordinates may span 280 bits (6e-17 beside 1e3 is common: cos 90° in exported files).
using BigInt =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;

/// A point over any number type, with the few operations the polynomials need.
template <class T>
struct Point {
  T x, y, z;
};
template <class T>
Point<T> operator-(const Point<T>& a, const Point<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
T dot(const Point<T>& a, const Point<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Point<T> cross(const Point<T>& a, const Point<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The common binary scale of a set of doubles.
struct BinaryScale {
  int lowest_bit = 1 << 20;  ///< exponent of the lowest set bit of all values
  int highest_bit = -(1 << 20);

  void include(double v) {
    if (v == 0) return;
    int exponent;
    const double mantissa = std::frexp(v, &exponent);  // v = mantissa * 2^exponent, 0.5 <= |mantissa| < 1
    const auto bits = static_cast<std::int64_t>(std::ldexp(std::fabs(mantissa), 53));
    const int low = exponent - 53 + __builtin_ctzll(static_cast<unsigned long long>(bits));
    if (low < lowest_bit) lowest_bit = low;
    if (exponent > highest_bit) highest_bit = exponent;
  }
  void include(const Vec3d& p) {
    include(p.x);
    include(p.y);
    include(p.z);
  }
  bool all_zero() const { return highest_bit < lowest_bit; }
  /// Bits of the largest scaled value.
  int width() const { return all_zero() ? 1 : highest_bit - lowest_bit; }

  /// v / 2^lowest_bit, exactly.
  template <class Int>
  Int scaled(double v) const {
    if (v == 0) return Int(0);
    int exponent;
    const double mantissa = std::frexp(v, &exponent);
    auto bits = static_cast<std::int64_t>(std::ldexp(mantissa, 53));
    const int shift = exponent - 53 - lowest_bit;
    if (shift >= 0) return Int(bits) << shift;
    return Int(bits / (std::int64_t{1} << -shift));  // exact: the low bits are zero by construction
  }
  template <class Int>
  Point<Int> scaled(const Vec3d& p) const {
    return {scaled<Int>(p.x), scaled<Int>(p.y), scaled<Int>(p.z)};
  }
};

template <class Int>
int sign_of(const Int& v) {
  return v.sign();
}

}  // namespace fracture::exact
