#include "common/exact/in_sphere.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/exact/number_types.hpp"
#include "common/exact/orient3d.hpp"

namespace fracture::exact {
namespace {

// With B = b - a, ..., E = e - a and [P, Q, R] the determinant of three rows:
//   f = |B|^2 [E, C, D] + |C|^2 [B, E, D] + |D|^2 [B, C, E] - |E|^2 [B, C, D]  > 0  <=>  e inside.
// Written with the six 2x2 minors of the xy columns (Shewchuk 1997, section 4.4).
//
// Error of the evaluation in doubles: a difference carries one rounding; a lift 5 (2 + 1 + 2 sums); a 3x3
// determinant 8; their product 14; three sums 17. Each [P, Q, R] has a permanent of at most sqrt(3) r^3 and
// each lift is at most r^2 with r = max |difference|, so the error is at most 4 sqrt(3) gamma_17 r^5 = 117.8
// * 2^-53 r^5, rounded up to 2^-46.
constexpr double kInSphereError = 0x1p-46;

template <class T>
T minor(const T& px, const T& py, const T& qx, const T& qy) {
  return px * qy - qx * py;
}

double in_sphere_double(const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e, double lift_b,
                        double lift_c, double lift_d, double lift_e) {
  const double bc = minor(b.x, b.y, c.x, c.y), bd = minor(b.x, b.y, d.x, d.y), be = minor(b.x, b.y, e.x, e.y),
               cd = minor(c.x, c.y, d.x, d.y), ce = minor(c.x, c.y, e.x, e.y), de = minor(d.x, d.y, e.x, e.y);
  const double cde = c.z * de - d.z * ce + e.z * cd;  // [C, D, E] = [E, C, D]
  const double bde = b.z * de - d.z * be + e.z * bd;  // [B, D, E] = -[B, E, D]
  const double bce = b.z * ce - c.z * be + e.z * bc;
  const double bcd = b.z * cd - c.z * bd + d.z * bc;
  return (lift_b * cde - lift_c * bde) + (lift_d * bce - lift_e * bcd);
}

// The types of the levels of the computation are chosen by the callers so that nothing overflows:
// minors <= 2 m^2, determinants <= 6 m^3, lifts <= 3 m^2, f <= 4 * 3 m^2 * 6 m^3 = 72 m^5 (all partial sums
// included).
template <class Minor, class Det, class Lift, class Result>
int sign_as(const IntPoint& b, const IntPoint& c, const IntPoint& d, const IntPoint& e) {
  const auto minor2 = [](const IntPoint& p, const IntPoint& q) {
    return static_cast<Minor>(p.x) * q.y - static_cast<Minor>(q.x) * p.y;
  };
  const auto lift = [](const IntPoint& p) {
    return static_cast<Lift>(p.x) * p.x + static_cast<Lift>(p.y) * p.y + static_cast<Lift>(p.z) * p.z;
  };
  const Minor bc = minor2(b, c), bd = minor2(b, d), be = minor2(b, e), cd = minor2(c, d), ce = minor2(c, e),
              de = minor2(d, e);
  const auto det = [](std::int64_t p, Minor pm, std::int64_t q, Minor qm, std::int64_t r, Minor rm) {
    return static_cast<Det>(p) * pm - static_cast<Det>(q) * qm + static_cast<Det>(r) * rm;
  };
  const Det cde = det(c.z, de, d.z, ce, e.z, cd), bde = det(b.z, de, d.z, be, e.z, bd),
            bce = det(b.z, ce, c.z, be, e.z, bc), bcd = det(b.z, cd, c.z, bd, d.z, bc);
  const Result f = (static_cast<Result>(lift(b)) * cde - static_cast<Result>(lift(c)) * bde) +
                   (static_cast<Result>(lift(d)) * bce - static_cast<Result>(lift(e)) * bcd);
  return (f > 0) - (f < 0);
}

int wide_sign(const IntPoint& b, const IntPoint& c, const IntPoint& d, const IntPoint& e) {
  const auto minor2 = [](const IntPoint& p, const IntPoint& q) {
    return static_cast<Int128>(p.x) * q.y - static_cast<Int128>(q.x) * p.y;
  };
  const auto lift = [](const IntPoint& p) {
    return static_cast<Int128>(p.x) * p.x + static_cast<Int128>(p.y) * p.y + static_cast<Int128>(p.z) * p.z;
  };
  const Int128 bc = minor2(b, c), bd = minor2(b, d), be = minor2(b, e), cd = minor2(c, d), ce = minor2(c, e),
               de = minor2(d, e);
  const auto det = [](std::int64_t p, Int128 pm, std::int64_t q, Int128 qm, std::int64_t r, Int128 rm) {
    return multiply(p, pm) - multiply(q, qm) + multiply(r, rm);
  };
  const WideInt<3> cde = det(c.z, de, d.z, ce, e.z, cd), bde = det(b.z, de, d.z, be, e.z, bd),
                   bce = det(b.z, ce, c.z, be, e.z, bc), bcd = det(b.z, cd, c.z, bd, d.z, bc);
  return ((multiply(lift(b), cde) - multiply(lift(c), bde)) +
          (multiply(lift(d), bce) - multiply(lift(e), bcd)))
      .sign();
}

int integer_sign(const IntPoint& b, const IntPoint& c, const IntPoint& d, const IntPoint& e) {
  const std::uint64_t bits = magnitude_bits(b) | magnitude_bits(c) | magnitude_bits(d) | magnitude_bits(e);
  using I64 = std::int64_t;
  if (bits < std::uint64_t{1} << 11) return sign_as<I64, I64, I64, I64>(b, c, d, e);     // 72 * 2^55 < 2^62
  if (bits < std::uint64_t{1} << 20) return sign_as<I64, I64, I64, Int128>(b, c, d, e);  // 6 * 2^60 < 2^63
  if (bits < std::uint64_t{1} << 24)
    return sign_as<I64, Int128, I64, Int128>(b, c, d, e);  // 72 * 2^120 < 2^127
  return wide_sign(b, c, d, e);
}

int any_size_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e) {
  BinaryScale scale;
  for (const Vec3d* p : {&a, &b, &c, &d, &e}) scale.include(*p);
  using P = Point<BigInt>;
  const P o = scale.scaled<BigInt>(a);
  const P rb = scale.scaled<BigInt>(b) - o, rc = scale.scaled<BigInt>(c) - o,
          rd = scale.scaled<BigInt>(d) - o, re = scale.scaled<BigInt>(e) - o;
  const BigInt f = dot(rb, rb) * dot(re, cross(rc, rd)) + dot(rc, rc) * dot(rb, cross(re, rd)) +
                   dot(rd, rd) * dot(rb, cross(rc, re)) - dot(re, re) * dot(rb, cross(rc, rd));
  return f.sign();
}

// f is exactly zero: the first site in lexicographic order with a non-zero cofactor decides (see the header).
// `less` compares two of the five sites, `cofactor` gives orient3d of the tetrahedron with vertex k replaced
// by e.
template <class Less, class Cofactor>
int break_tie(Less less, Cofactor cofactor) {
  std::array<int, 5> order{0, 1, 2, 3, 4};
  for (int k = 0; k < 5; ++k) {
    for (int i = k + 1; i < 5; ++i)
      if (less(order[i], order[k])) std::swap(order[k], order[i]);
    if (order[k] == 4) return 1;
    const int sign = cofactor(order[k]);
    if (sign != 0) return -sign;
  }
  return 1;  // not reached: e is one of the five
}

}  // namespace

int in_sphere_exact(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e,
                    const PointScale& given, PredicateCounters* counters) {
  PointScale scale = given;
  if (!scale.fits()) {
    ScaleBuilder builder;
    for (const Vec3d* p : {&a, &b, &c, &d, &e}) builder.include(*p);
    scale = builder.scale();
  }
  if (counters) ++counters->exact;
  if (scale.fits()) {
    const IntPoint o = to_integers(a, scale);
    const std::array<IntPoint, 5> p{IntPoint{0, 0, 0}, to_integers(b, scale) - o, to_integers(c, scale) - o,
                                    to_integers(d, scale) - o, to_integers(e, scale) - o};
    const int sign = integer_sign(p[1], p[2], p[3], p[4]);
    if (sign != 0) return sign;
    if (counters) ++counters->ties;
    return break_tie([&](int i, int j) { return lexicographic_less(p[i], p[j]); },
                     [&](int k) {
                       std::array<IntPoint, 4> t{p[0], p[1], p[2], p[3]};
                       t[k] = p[4];
                       return orient3d_sign(t[1] - t[0], t[2] - t[0], t[3] - t[0]);
                     });
  }
  const int sign = any_size_sign(a, b, c, d, e);
  if (sign != 0) return sign;
  if (counters) ++counters->ties;
  const std::array<Vec3d, 5> p{a, b, c, d, e};
  return break_tie([&](int i, int j) { return lexicographic_less(p[i], p[j]); },
                   [&](int k) {
                     std::array<Vec3d, 4> t{a, b, c, d};
                     t[k] = e;
                     return orient3d_exact(t[0], t[1], t[2], t[3], scale);
                   });
}

int in_sphere(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e) {
  const Vec3d rb = b - a, rc = c - a, rd = d - a, re = e - a;
  const double lb = dot(rb, rb), lc = dot(rc, rc), ld = dot(rd, rd), le = dot(re, re);
  const double f = in_sphere_double(rb, rc, rd, re, lb, lc, ld, le);
  const double r2 = std::max(std::max(lb, lc), std::max(ld, le));
  const double bound = kInSphereError * r2 * r2 * std::sqrt(r2) + kUnderflow;
  if (f > bound) return 1;
  if (f < -bound) return -1;
  return in_sphere_exact(a, b, c, d, e, PointScale{});
}

}  // namespace fracture::exact
