#include "common/exact/orient3d.hpp"

#include <cmath>

#include "common/exact/number_types.hpp"
#include "common/exact/wide_int.hpp"

namespace fracture::exact {
namespace {

template <class T>
int sign_as(const IntPoint& b, const IntPoint& c, const IntPoint& d) {
  const auto to = [](const IntPoint& p) { return Point<T>{p.x, p.y, p.z}; };
  return sign_of(dot(to(b), cross(to(c), to(d))));
}

/// Sign of det[b; c; d] for exact differences, all below 2^62 in magnitude. |det| and its partial sums are at
/// most 6 m^3 if all |differences| <= m.
int integer_sign(const IntPoint& b, const IntPoint& c, const IntPoint& d) {
  const std::uint64_t bits = magnitude_bits(b) | magnitude_bits(c) | magnitude_bits(d);
  if (bits < std::uint64_t{1} << 20) return sign_as<std::int64_t>(b, c, d);  // 6 * 2^60 < 2^63
  if (bits < std::uint64_t{1} << 41) return sign_as<Int128>(b, c, d);        // 6 * 2^123 < 2^127
  const auto minor = [](std::int64_t p, std::int64_t q, std::int64_t r, std::int64_t s) {
    return static_cast<Int128>(p) * q - static_cast<Int128>(r) * s;
  };
  return (multiply(b.x, minor(c.y, d.z, c.z, d.y)) + multiply(b.y, minor(c.z, d.x, c.x, d.z)) +
          multiply(b.z, minor(c.x, d.y, c.y, d.x)))
      .sign();
}

template <class Int>
int scaled_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const BinaryScale& scale) {
  const Point<Int> o = scale.scaled<Int>(a);
  const Int det = dot(scale.scaled<Int>(b) - o, cross(scale.scaled<Int>(c) - o, scale.scaled<Int>(d) - o));
  return sign_of(det);
}

int exact_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const BinaryScale& given) {
  if (given.fits()) {
    // If the points are within 2^16 steps of each other, 6 m^3 < 2^53 and doubles are exact.
    const double s = given.factor();
    const Vec3d rb = s * (b - a), rc = s * (c - a), rd = s * (d - a);
    bool near = true;
    for (const Vec3d* r : {&rb, &rc, &rd})
      near &= std::fabs(r->x) <= 0x1p16 && std::fabs(r->y) <= 0x1p16 && std::fabs(r->z) <= 0x1p16;
    if (near) return sign_of(det3(rb, rc, rd));
  }
  BinaryScale own;
  if (!given.fits())
    for (const Vec3d* p : {&a, &b, &c, &d}) own.include(*p);
  const BinaryScale& scale = given.fits() ? given : own;
  if (scale.fits()) {
    const IntPoint o = scale.to_integers(a);
    return integer_sign(scale.to_integers(b) - o, scale.to_integers(c) - o, scale.to_integers(d) - o);
  }
  // Differences have one more bit than coordinates, and 6 < 2^3.
  if (3 * (scale.width() + 1) + 3 <= 1000) return scaled_sign<FixedInt>(a, b, c, d, scale);
  return scaled_sign<BigInt>(a, b, c, d, scale);
}

}  // namespace

int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const BinaryScale& scale,
             PredicateCounters* counters) {
  const Vec3d ba = b - a, ca = c - a, da = d - a;
  const double det = det3(ba, ca, da);
  const double bound = orient3d_bound(ba, ca, da);
  if (det > bound) return 1;
  if (det < -bound) return -1;
  const int sign = exact_sign(a, b, c, d, scale);
  if (counters) {
    ++counters->exact;
    counters->ties += sign == 0;
  }
  return sign;
}

}  // namespace fracture::exact
