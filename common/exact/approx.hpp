// A double with a running bound on its error: the floating-point filter for polynomials that are evaluated
// too rarely to deserve a hand-derived static bound. A polynomial is written once, as a template over its
// number type, and evaluated first with Approx and, where Approx cannot certify the sign, with integers
// (number_types.hpp).
#pragma once

#include <cmath>

namespace fracture::exact {

/// What underflow may add to the error of any polynomial of this room; each filter says why it is enough.
inline constexpr double kUnderflow = 1e-200;

/// For bounds. std::fmax is a library call (it must treat NaN); this is one instruction.
inline double larger(double a, double b) { return a > b ? a : b; }

/// The true value lies within bound() of `value`. `error` alone covers the roundings of the values, but
/// neither its own roundings nor underflow; bound() covers both.
///
/// Underflow (Meyer & Pion 2008, "FPG: A code generator for fast and certified geometric predicates"). With
/// gradual underflow a sum is exact where it is subnormal; a product loses at most 2^-1075. An operation
/// makes at most five products (of values and of error terms), so what it loses beside relative roundings is
/// at most 2^-1072. Later operations multiply that loss by the other factors of the polynomial: in a
/// polynomial of degree at most 9 by at most seven differences of coordinates, each below 2^45 (sites and
/// meshes reach 1e12, the corners of the big tetrahedron less than 2e13), in at most 2^10 monomials. A
/// thousand operations therefore lose less than 2^-1072 * 2^(7 * 45) * 2^10 * 2^10 = 2^-737 < kUnderflow =
/// 1e-200 in all, absolutely: the floor holds for the value of a whole polynomial in such coordinates, not
/// for what was divided since.
struct Approx {
  double value = 0;
  double error = 0;

  Approx() = default;
  Approx(double v) : value(v) {}  // NOLINT: a double is an exact Approx
  Approx(double v, double e) : value(v), error(e) {}

  friend Approx operator+(const Approx& a, const Approx& b) {
    const double v = a.value + b.value;
    return {v, a.error + b.error + kUlp * std::fabs(v)};
  }
  friend Approx operator-(const Approx& a, const Approx& b) {
    const double v = a.value - b.value;
    return {v, a.error + b.error + kUlp * std::fabs(v)};
  }
  friend Approx operator*(const Approx& a, const Approx& b) {
    const double v = a.value * b.value;
    return {v, std::fabs(a.value) * b.error + std::fabs(b.value) * a.error + a.error * b.error +
                   kUlp * std::fabs(v)};
  }

  /// |true value - value| is at most this, for polynomials as described above: the factor 1.001 absorbs the
  /// rounding of the error terms (fewer than 1,000 operations at 2^-52 each), the floor absorbs underflow.
  double bound() const { return 1.001 * error + kUnderflow; }

  /// Sign of the true value, or 0 when it cannot be told.
  int certified_sign() const {
    if (std::fabs(value) > bound() && std::fabs(value) < HUGE_VAL) return value > 0 ? 1 : -1;
    return 0;
  }

 private:
  static constexpr double kUlp = 0x1.0p-52;  // twice the unit roundoff: room for the rounding of `error`
};

}  // namespace fracture::exact
