// Unevaluated sums of two doubles: 106 bits of precision, between doubles and integers. Dekker 1971; the
// algorithms and bounds are those of Joldes, Muller & Popescu 2017 ("Tight and rigorous error bounds for
// basic building blocks of double-word arithmetic"). Products use Dekker's splitting, because no fused
// multiply-add is assumed.
#pragma once

#include <cmath>

namespace fracture::clip_detail {

/// hi + lo, |lo| <= ulp(hi) / 2. The error of each operation is less than 2^-100 of its result, plus the loss
/// from underflow. Magnitudes must stay below 2^900.
struct DoubleDouble {
  double hi = 0, lo = 0;

  DoubleDouble() = default;
  DoubleDouble(double v) : hi(v) {}  // NOLINT: a double is an exact DoubleDouble
  DoubleDouble(double h, double l) : hi(h), lo(l) {}

  /// Requires |a| >= |b| or a = 0.
  static DoubleDouble quick_sum(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
  }
  static DoubleDouble exact_sum(double a, double b) {
    const double s = a + b, bb = s - a;
    return {s, (a - (s - bb)) + (b - bb)};
  }
  static DoubleDouble exact_product(double a, double b) {
    constexpr double kSplitter = 0x1.0p27 + 1;
    const double ca = kSplitter * a, cb = kSplitter * b;
    const double ah = ca - (ca - a), al = a - ah, bh = cb - (cb - b), bl = b - bh;
    const double p = a * b;
    return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
  }

  friend DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
    const DoubleDouble s = exact_sum(a.hi, b.hi), t = exact_sum(a.lo, b.lo);
    const DoubleDouble v = quick_sum(s.hi, s.lo + t.hi);
    return quick_sum(v.hi, t.lo + v.lo);
  }
  DoubleDouble operator-() const { return {-hi, -lo}; }
  friend DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + -b; }
  friend DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
    const DoubleDouble p = exact_product(a.hi, b.hi);
    return quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
  }
  friend DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
    // Three quotients of 53 bits each: one more than is kept.
    const double q = a.hi / b.hi;
    DoubleDouble rest = a - b * q;
    const double r = rest.hi / b.hi;
    rest = rest - b * r;
    return DoubleDouble(quick_sum(q, r)) + rest.hi / b.hi;
  }
};

}  // namespace fracture::clip_detail
