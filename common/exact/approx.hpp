// A double with a running bound on its error: the floating-point filter for polynomials that are evaluated
// too rarely to deserve a hand-derived static bound. A polynomial is written once, as a template over its
// number type, and evaluated first with Approx and, where Approx cannot certify the sign, with integers
// (number_types.hpp).
#pragma once

#include <cmath>

namespace fracture::exact {

/// The true value lies in [value - error, value + error], up to the relative rounding of `error` itself,
/// which certified_sign() covers by its slack.
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

  /// Sign of the true value, or 0 when it cannot be told. The factor 1.001 absorbs the rounding of the error
  /// terms (fewer than 1,000 operations at 2^-52 each); the floor absorbs underflow: coordinates are at most
  /// 1e12 in magnitude and the polynomials of degree at most 9, so an underflow of 2^-1074 grows to at most
  /// 1e-215.
  int certified_sign() const {
    if (std::fabs(value) > 1.001 * error + 1e-200 && std::fabs(value) < HUGE_VAL) return value > 0 ? 1 : -1;
    return 0;
  }

 private:
  static constexpr double kUlp = 0x1.0p-52;  // twice the unit roundoff: room for the rounding of `error`
};

}  // namespace fracture::exact
