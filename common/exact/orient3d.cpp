#include "common/exact/orient3d.hpp"

#include <cmath>

#include "common/exact/number_types.hpp"

namespace fracture::exact {
namespace {

template <class T>
T det3_of(const T& bx, const T& by, const T& bz, const T& cx, const T& cy, const T& cz, const T& dx,
          const T& dy, const T& dz) {
  return bx * (cy * dz - cz * dy) + by * (cz * dx - cx * dz) + bz * (cx * dy - cy * dx);
}

template <class T>
int sign_as(const IntPoint& b, const IntPoint& c, const IntPoint& d) {
  const T det = det3_of<T>(b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z);
  return (det > 0) - (det < 0);
}

template <class Int>
int scaled_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const BinaryScale& scale) {
  const Point<Int> o = scale.scaled<Int>(a);
  const Int det = dot(scale.scaled<Int>(b) - o, cross(scale.scaled<Int>(c) - o, scale.scaled<Int>(d) - o));
  return det.sign();
}

int any_size_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  BinaryScale scale;
  for (const Vec3d* p : {&a, &b, &c, &d}) scale.include(*p);
  // Differences have one bit more than coordinates, and 6 < 2^3.
  if (3 * (scale.width() + 1) + 3 <= 1000) return scaled_sign<FixedInt>(a, b, c, d, scale);
  return scaled_sign<BigInt>(a, b, c, d, scale);
}

}  // namespace

// |det| and its partial sums are at most 6 m^3 where all |differences| <= m.
int orient3d_sign(const IntPoint& b, const IntPoint& c, const IntPoint& d) {
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

int orient3d_exact(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const PointScale& given,
                   PredicateCounters* counters) {
  if (counters) ++counters->exact;
  if (given.fits()) {
    // Within 2^16 steps of each other: 6 m^3 < 2^53, doubles are exact.
    const Vec3d rb = given.scale * (b - a), rc = given.scale * (c - a), rd = given.scale * (d - a);
    bool near = true;
    for (const Vec3d* r : {&rb, &rc, &rd})
      near &= std::fabs(r->x) <= 0x1p16 && std::fabs(r->y) <= 0x1p16 && std::fabs(r->z) <= 0x1p16;
    if (near) {
      const double det = det3(rb, rc, rd);
      if (counters) counters->ties += det == 0;
      return (det > 0) - (det < 0);
    }
  }
  PointScale scale = given;
  if (!scale.fits()) {
    ScaleBuilder builder;
    for (const Vec3d* p : {&a, &b, &c, &d}) builder.include(*p);
    scale = builder.scale();
  }
  int sign;
  if (scale.fits()) {
    const IntPoint o = to_integers(a, scale);
    sign = orient3d_sign(to_integers(b, scale) - o, to_integers(c, scale) - o, to_integers(d, scale) - o);
  } else {
    sign = any_size_sign(a, b, c, d);
  }
  if (counters) counters->ties += sign == 0;
  return sign;
}

int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Vec3d ba = b - a, ca = c - a, da = d - a;
  const double det = det3(ba, ca, da);
  const double bound = orient3d_bound(ba, ca, da);
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return orient3d_exact(a, b, c, d, PointScale{});
}

}  // namespace fracture::exact
