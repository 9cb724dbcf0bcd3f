// The volume of a closed surface if doubles cancel: for needles, the cross products are tiny compared with
// the products that are subtracted. Each value is the unevaluated sum of two doubles, about 106 bits (Dekker
// 1971, "A floating-point technique for extending the available precision"; sums as in Knuth, TAOCP 2,
// 4.2.2).
#pragma once

#include <algorithm>
#include <cmath>

#include "common/base/vec.hpp"

namespace fracture::exact {

struct DoubleDouble {
  double high = 0, low = 0;
};

/// a + b without rounding error.
inline DoubleDouble two_sum(double a, double b) {
  const double s = a + b, t = s - a;
  return {s, (a - (s - t)) + (b - t)};
}
inline DoubleDouble operator-(const DoubleDouble& a) { return {-a.high, -a.low}; }
inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  DoubleDouble s = two_sum(a.high, b.high);
  const DoubleDouble t = two_sum(a.low, b.low);
  s = two_sum(s.high, s.low + t.high);
  return two_sum(s.high, s.low + t.low);
}
inline DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + -b; }
inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const double p = a.high * b.high;
  return two_sum(p, std::fma(a.high, b.high, -p) + (a.high * b.low + a.low * b.high));
}

/// Sums the tetrahedra that triangles form with an origin.
class VolumeSum {
 public:
  explicit VolumeSum(const Vec3d& origin) : origin_(origin) {}

  /// Adds a triangle, counter-clockwise seen from outside.
  void add(const Vec3d& p, const Vec3d& q, const Vec3d& r) {
    DoubleDouble a[3], b[3], c[3];
    for (int k = 0; k < 3; ++k) {
      a[k] = two_sum(p[k], -origin_[k]);
      b[k] = two_sum(q[k], -origin_[k]);
      c[k] = two_sum(r[k], -origin_[k]);
    }
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      six_ = six_ + a[k] * (b[i] * c[j] - b[j] * c[i]);
    }
  }
  /// The volume, in cubed units of the coordinates.
  double volume() const { return (six_.high + six_.low) / 6; }

 private:
  Vec3d origin_;
  DoubleDouble six_;
};

inline double max_norm(const Vec3d& v) {
  return std::max(std::fabs(v.x), std::max(std::fabs(v.y), std::fabs(v.z)));
}

/// Whether a sum in doubles of (a - origin) . ((b - a) x (c - a)) / 6 may have a relative error above 1e-10.
/// `products`: the sum of max_norm(b - a) max_norm(c - a); `size`: upper bound of max_norm(a - origin). The
/// error of a component of a cross product is at most 2^-51 of that product, and three of them in a scalar
/// product have three times as much. 2^-48 leaves room for the differences and the sum.
inline bool cancels(double volume, double products, double size) {
  return 0x1.0p-48 / 6 * products * size > 1e-10 * std::fabs(volume);
}

}  // namespace fracture::exact
