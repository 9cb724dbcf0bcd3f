// Converts doubles to integers. Every finite double is an integer multiple of a power of two. So if the
// coordinates of a set of points are divided by the smallest such power among them, they become integers. The
// sign of a polynomial is then an integer computation without rounding.
#pragma once

#include <bit>
#include <cstdint>

#include "common/base/vec.hpp"

namespace fracture::exact {

/// A point over any number type, with the few operations that the polynomials need.
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
/// A point in steps of a scale that fits.
using IntPoint = Point<std::int64_t>;

/// The common step 2^lowest_bit() of a set of doubles. If all are at most 2^61 steps large, the set *fits*.
/// Then the widths of all polynomials are known in advance, and the arithmetic needs no allocation, no loops
/// and no normalisation (wide_int.hpp). This covers every set of doubles within a range of 61 bits, in
/// particular lattices such as k/21 (58 bits) and generated sites (23 bits with the corners).
///
/// An empty scale does not fit. Predicates that receive one compute the scale of the few points of each call.
class BinaryScale {
 public:
  /// Then differences are below 2^62, and in_sphere is 48 * (2^62)^5 < 2^317 < 2^319.
  static constexpr int kMaxBits = 61;

  void include(double v) {
    const Parts parts = parts_of(v);
    if (parts.mantissa == 0) return;
    const int low = parts.exponent + std::countr_zero(parts.mantissa);
    const int top = parts.exponent + std::bit_width(parts.mantissa);
    if (low >= lowest_bit_ && top <= top_bit_) return;
    if (low < lowest_bit_) lowest_bit_ = low;
    if (top > top_bit_) top_bit_ = top;
    // 2^-lowest_bit_ must be a normal double.
    const bool fits = width() <= kMaxBits && lowest_bit_ >= -1000 && lowest_bit_ <= 1000;
    factor_ = fits ? std::bit_cast<double>(static_cast<std::uint64_t>(1023 - lowest_bit_) << 52) : 0;
  }
  void include(const Vec3d& p) {
    include(p.x);
    include(p.y);
    include(p.z);
  }

  /// Exponent of the lowest set bit of all values.
  int lowest_bit() const { return lowest_bit_; }
  /// Number of bits of the largest value, in steps.
  int width() const { return top_bit_ < lowest_bit_ ? 1 : top_bit_ - lowest_bit_; }
  bool fits() const { return factor_ != 0; }
  /// Factor that converts a value to steps; 0 if the set does not fit.
  double factor() const { return factor_; }

  /// Converts included coordinates to steps, exactly; the set must fit.
  IntPoint to_integers(const Vec3d& p) const {
    return {static_cast<std::int64_t>(p.x * factor_), static_cast<std::int64_t>(p.y * factor_),
            static_cast<std::int64_t>(p.z * factor_)};
  }
  /// Converts an included value to steps, exactly; Int must be wide enough.
  template <class Int>
  Int scaled(double v) const {
    const Parts parts = parts_of(v);
    if (parts.mantissa == 0) return Int(0);
    const int shift = parts.exponent - lowest_bit_;
    // A shift to the right loses nothing: the low bits are zero, because otherwise lowest_bit_ would be
    // lower.
    const Int magnitude = shift >= 0 ? Int(Int(parts.mantissa) << shift) : Int(parts.mantissa >> -shift);
    return v < 0 ? Int(-magnitude) : magnitude;
  }
  template <class Int>
  Point<Int> scaled(const Vec3d& p) const {
    return {scaled<Int>(p.x), scaled<Int>(p.y), scaled<Int>(p.z)};
  }

 private:
  /// |v| = mantissa * 2^exponent.
  struct Parts {
    std::uint64_t mantissa;
    int exponent;
  };
  static Parts parts_of(double v) {
    const auto bits = std::bit_cast<std::uint64_t>(v);
    const int biased = static_cast<int>(bits >> 52 & 0x7ff);
    std::uint64_t mantissa = bits & ((std::uint64_t{1} << 52) - 1);
    if (biased != 0) mantissa |= std::uint64_t{1} << 52;
    return {mantissa, (biased != 0 ? biased : 1) - 1075};
  }

  int lowest_bit_ = 1 << 20;  // nothing yet
  int top_bit_ = -(1 << 20);  // all |values| < 2^top_bit_
  double factor_ = 0;
};

}  // namespace fracture::exact
