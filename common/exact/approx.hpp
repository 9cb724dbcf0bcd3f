// A double with a running error bound: the floating-point filter for polynomials that are evaluated too
// rarely to justify a hand-derived static bound. A polynomial is written once, as a template over its number
// type. It is evaluated with Approx first and, if that cannot certify the sign, with integers
// (number_types.hpp).
#pragma once

#include <cmath>

namespace fracture::exact {

/// Upper bound of the error that underflow adds to a polynomial of this module. Each filter explains why it
/// is sufficient.
inline constexpr double kUnderflow = 1e-200;

/// For bounds. std::fmax is a library call (because it must handle NaN); this is one instruction.
inline double larger(double a, double b) { return a > b ? a : b; }

/// The true value is within bound() of `value`. `error` alone covers the rounding errors of the values, but
/// neither its own rounding errors nor underflow; bound() covers both.
///
/// Underflow (Meyer & Pion 2008, "FPG: A code generator for fast and certified geometric predicates"): with
/// gradual underflow, a sum is exact if it is subnormal, and a product loses at most 2^-1075. An operation
/// computes at most five products (of values and of error terms), so it loses at most 2^-1072 in addition to
/// relative rounding errors. Later operations multiply that loss by the other factors of the polynomial. A
/// polynomial of degree at most 9 has at most seven such factors, which are differences of coordinates, and
/// at most 2^10 monomials. Each difference is below 2^45 (sites and meshes reach 1e12, and the corners of the big
/// tetrahedron less than 2e13). So a thousand operations lose less than 2^-1072 * 2^(7 * 45) * 2^10 * 2^10 =
/// 2^-737 < kUnderflow = 1e-200 in total. This is an absolute bound for the value of a whole polynomial in
/// such coordinates, but not for quotients.
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

  /// |true value - value| is at most this, for polynomials as described above. The factor 1.001 covers the
  /// rounding of the error terms (fewer than 1,000 operations at 2^-52 each), and the constant covers
  /// underflow.
  double bound() const { return 1.001 * error + kUnderflow; }

  /// Sign of the true value, or 0 if it is uncertain.
  int certified_sign() const {
    if (std::fabs(value) > bound() && std::fabs(value) < HUGE_VAL) return value > 0 ? 1 : -1;
    return 0;
  }

 private:
  static constexpr double kUlp = 0x1.0p-52;  // twice the unit roundoff, with room for the rounding of `error`
};

}  // namespace fracture::exact
