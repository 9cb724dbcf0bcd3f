#include "common/exact/in_sphere.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "common/exact/approx.hpp"
#include "common/exact/number_types.hpp"
#include "common/exact/wide_int.hpp"

namespace fracture::exact {
namespace {

// Let B = b - a, ..., E = e - a, and let [P, Q, R] be the determinant of three rows. Site e is inside if
//   f = |B|^2 [E, C, D] + |C|^2 [B, E, D] + |D|^2 [B, C, E] - |E|^2 [B, C, D]  > 0.
// It is evaluated with the six 2x2 minors of the xy columns (Shewchuk 1997, section 4.4).
//
// Error of the evaluation in doubles: a difference has one rounding; a lift 5 (2 + 1 + 2 sums); a 3x3
// determinant 8; their product 14; three sums 17. Each [P, Q, R] has a permanent of at most sqrt(3) r^3, and
// each lift is at most r^2, where r = max |difference|. So the error is at most 4 sqrt(3) gamma_17 r^5 =
// 117.8 * 2^-53 r^5, rounded up to 2^-46 = 128 * 2^-53. The remaining 10 * 2^-53 r^5 cover the second-order
// terms and the rounding of the bound, whose r^2 is the largest computed lift.
//
// Underflow (Meyer & Pion 2008): a product loses at most h = 2^-1075, and sums lose nothing. A minor loses 2
// h, a determinant 6 h r + 3 h, and a lift 3 h. These are multiplied by lifts of at most r^2 and determinants
// of at most 6 r^3, four of each. The total is less than 200 h (1 + r^3). If r <= 1, that is below 2^-1066,
// far below kUnderflow. If r > 1, it is below 2^-1066 r^5, far below the unused part of kInSphereError. The
// computed r^2 is too small by 3 h. If it is at least 2^-1000, that is one more rounding. If it is less, |f|
// <= 72 (2^-999)^2.5 and its computed value are far below kUnderflow, so the exact path decides.
constexpr double kInSphereError = 0x1p-46;

/// Maximum difference, in steps, for exact doubles: 72 m^5 < 2^53, so every operation on doubles is exact
/// (even the differences).
constexpr double kExactInDoubles = 512;

template <class T>
T minor(const T& px, const T& py, const T& qx, const T& qy) {
  return px * qy - qx * py;
}

/// The sign of f, and the signs of its derivatives with respect to the lifted coordinates of a, b, c, d, e,
/// which are the cofactors of the tie rule.
struct Decision {
  int sign;
  std::array<int, 5> cofactor;  // only if sign == 0
};

/// cde = [C, D, E] = [E, C, D], bde = [B, D, E] = -[B, E, D], bce = [B, C, E], bcd = [B, C, D]. The cofactor
/// of a is minus the sum of the others, because lifts are relative to a.
template <class Number, class Det>
Decision decide(const Number& f, const Det& cde, const Det& bde, const Det& bce, const Det& bcd) {
  const int sign = sign_of(f);
  if (sign != 0) return {sign, {}};
  return {0, {sign_of((bde - cde) + (bcd - bce)), sign_of(cde), -sign_of(bde), sign_of(bce), -sign_of(bcd)}};
}

struct InSphereDoubles {
  double f, cde, bde, bce, bcd;
};
InSphereDoubles in_sphere_doubles(const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e,
                                  double lift_b, double lift_c, double lift_d, double lift_e) {
  const double bc = minor(b.x, b.y, c.x, c.y), bd = minor(b.x, b.y, d.x, d.y), be = minor(b.x, b.y, e.x, e.y),
               cd = minor(c.x, c.y, d.x, d.y), ce = minor(c.x, c.y, e.x, e.y), de = minor(d.x, d.y, e.x, e.y);
  const double cde = c.z * de - d.z * ce + e.z * cd;
  const double bde = b.z * de - d.z * be + e.z * bd;
  const double bce = b.z * ce - c.z * be + e.z * bc;
  const double bcd = b.z * cd - c.z * bd + d.z * bc;
  return {(lift_b * cde - lift_c * bde) + (lift_d * bce - lift_e * bcd), cde, bde, bce, bcd};
}

// Callers choose the types of each level of the computation so that nothing overflows, including partial
// sums:
//   minors <= 2 m^2, determinants <= 6 m^3, lifts <= 3 m^2, f <= 4 * 3 m^2 * 6 m^3 = 72 m^5.
template <class Minor, class Det, class Lift, class Result>
Decision decide_as(const IntPoint& b, const IntPoint& c, const IntPoint& d, const IntPoint& e) {
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
  return decide(f, cde, bde, bce, bcd);
}

Decision decide_wide(const IntPoint& b, const IntPoint& c, const IntPoint& d, const IntPoint& e) {
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
  const WideInt<5> f =
      (multiply(lift(b), cde) - multiply(lift(c), bde)) + (multiply(lift(d), bce) - multiply(lift(e), bcd));
  return decide(f, cde, bde, bce, bcd);
}

Decision decide_integers(const std::array<IntPoint, 5>& p) {
  const IntPoint &b = p[1], &c = p[2], &d = p[3], &e = p[4];
  const std::uint64_t bits = magnitude_bits(b) | magnitude_bits(c) | magnitude_bits(d) | magnitude_bits(e);
  using I64 = std::int64_t;
  if (bits < std::uint64_t{1} << 11) return decide_as<I64, I64, I64, I64>(b, c, d, e);     // 72 * 2^55 < 2^62
  if (bits < std::uint64_t{1} << 20) return decide_as<I64, I64, I64, Int128>(b, c, d, e);  // 6 * 2^60 < 2^63
  if (bits < std::uint64_t{1} << 24)
    return decide_as<I64, Int128, I64, Int128>(b, c, d, e);  // 72 * 2^120 < 2^127
  return decide_wide(b, c, d, e);
}

template <class Int>
Decision decide_scaled(const std::array<Vec3d, 5>& p, const BinaryScale& scale) {
  using P = Point<Int>;
  const P o = scale.scaled<Int>(p[0]);
  const P b = scale.scaled<Int>(p[1]) - o, c = scale.scaled<Int>(p[2]) - o, d = scale.scaled<Int>(p[3]) - o,
          e = scale.scaled<Int>(p[4]) - o;
  const Int cde = dot(c, cross(d, e)), bde = dot(b, cross(d, e)), bce = dot(b, cross(c, e)),
            bcd = dot(b, cross(c, d));
  const Int f = dot(b, b) * cde - dot(c, c) * bde + dot(d, d) * bce - dot(e, e) * bcd;
  return decide(f, cde, bde, bce, bcd);
}

Decision decide_any_size(const std::array<Vec3d, 5>& p, const BinaryScale& scale) {
  // Differences have one more bit than coordinates, and 72 < 2^7.
  if (5 * (scale.width() + 1) + 7 <= 1000) return decide_scaled<FixedInt>(p, scale);
  return decide_scaled<BigInt>(p, scale);
}

// Comparisons compile to a few instructions without branches, because in a lattice they are unpredictable.
bool is_less(const IntPoint& a, const IntPoint& b) {
  return (a.x < b.x) | ((a.x == b.x) & ((a.y < b.y) | ((a.y == b.y) & (a.z < b.z))));
}
bool is_less(const Vec3d& a, const Vec3d& b) { return lexicographic_less(a, b); }
bool is_less(double a, double b) { return a < b; }

/// The lexicographic order of small integers as one number: |y|, |z| <= kExactInDoubles < 2^10.
double lexicographic_key(const Vec3d& p) { return (p.x * 0x1p11 + p.y) * 0x1p11 + p.z; }

// f is exactly zero: the first site in lexicographic order with a nonzero cofactor decides (see the header).
template <class P>  // anything with is_less()
int break_tie(const std::array<P, 5>& p, const std::array<int, 5>& cofactor) {
  int least = 0;
  for (int i = 1; i < 5; ++i) least = is_less(p[i], p[least]) ? i : least;
  if (cofactor[least] != 0) return -cofactor[least];
  std::array<int, 5> order{0, 1, 2, 3, 4};
  for (int k = 0; k < 5; ++k) {
    for (int i = k + 1; i < 5; ++i)
      if (is_less(p[order[i]], p[order[k]])) std::swap(order[k], order[i]);
    if (cofactor[order[k]] != 0) return -cofactor[order[k]];
  }
  return 1;  // not reached, because the cofactor of e is the volume
}

}  // namespace

int in_sphere_exact(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e,
                    const BinaryScale& given, PredicateCounters* counters) {
  const auto conclude = [&](const auto& points, const Decision& decision) {
    if (counters) {
      ++counters->exact;
      counters->ties += decision.sign == 0;
    }
    return decision.sign != 0 ? decision.sign : break_tie(points, decision.cofactor);
  };
  BinaryScale own;
  if (given.fits()) {
    // On a lattice, the points are usually a few steps apart. Then doubles are exact integers too, and need
    // no conversion.
    const double s = given.factor();
    const std::array<Vec3d, 5> p{Vec3d{}, s * (b - a), s * (c - a), s * (d - a), s * (e - a)};
    double m = 0;
    for (int k = 1; k < 5; ++k)
      m = larger(larger(m, std::fabs(p[k].x)), larger(std::fabs(p[k].y), std::fabs(p[k].z)));
    if (m <= kExactInDoubles) {
      const InSphereDoubles r = in_sphere_doubles(p[1], p[2], p[3], p[4], dot(p[1], p[1]), dot(p[2], p[2]),
                                                  dot(p[3], p[3]), dot(p[4], p[4]));
      std::array<double, 5> keys;
      for (int k = 0; k < 5; ++k) keys[k] = lexicographic_key(p[k]);
      return conclude(keys, decide(r.f, r.cde, r.bde, r.bce, r.bcd));
    }
  } else {
    for (const Vec3d* p : {&a, &b, &c, &d, &e}) own.include(*p);
  }
  const BinaryScale& scale = given.fits() ? given : own;
  if (!scale.fits()) {
    const std::array<Vec3d, 5> p{a, b, c, d, e};
    return conclude(p, decide_any_size(p, scale));
  }
  const IntPoint o = scale.to_integers(a);
  const std::array<IntPoint, 5> p{IntPoint{0, 0, 0}, scale.to_integers(b) - o, scale.to_integers(c) - o,
                                  scale.to_integers(d) - o, scale.to_integers(e) - o};
  return conclude(p, decide_integers(p));
}

int in_sphere(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e) {
  return in_sphere(a, b, c, d, e, {});
}

int in_sphere(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e,
              const BinaryScale& scale, PredicateCounters* counters) {
  const Vec3d rb = b - a, rc = c - a, rd = d - a, re = e - a;
  const double lb = dot(rb, rb), lc = dot(rc, rc), ld = dot(rd, rd), le = dot(re, re);
  const double r2 = larger(larger(lb, lc), larger(ld, le));
  if (r2 * scale.factor() * scale.factor() <= kExactInDoubles * kExactInDoubles && scale.fits())
    return in_sphere_exact(a, b, c, d, e, scale, counters);  // doubles without rounding errors are as fast
  const double f = in_sphere_doubles(rb, rc, rd, re, lb, lc, ld, le).f;
  const double bound = kInSphereError * r2 * r2 * std::sqrt(r2) + kUnderflow;
  if (f > bound) return 1;
  if (f < -bound) return -1;
  return in_sphere_exact(a, b, c, d, e, scale, counters);
}

}  // namespace fracture::exact
