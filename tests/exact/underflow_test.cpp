// The predicates over the whole range of doubles that they accept, where squares, products and whole
// polynomials underflow. They are compared with rational arithmetic, which has an unlimited range. Ties are
// not tested here (see side_test.cpp and in_sphere_test.cpp): if the rational polynomial of a side predicate
// is zero, nothing is compared.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "common/base/random.hpp"
#include "common/exact/approx.hpp"
#include "common/exact/in_sphere.hpp"
#include "common/exact/orient3d.hpp"
#include "common/exact/side.hpp"
#include "tests/exact/rational_oracle.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::exact {
namespace {

using test::Rational;
using QVec = std::array<Rational, 3>;

QVec q(const Vec3d& p) { return {Rational(p.x), Rational(p.y), Rational(p.z)}; }
QVec operator-(const QVec& a, const QVec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
QVec operator+(const QVec& a, const QVec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
QVec operator*(const Rational& s, const QVec& a) { return {s * a[0], s * a[1], s * a[2]}; }
Rational dot(const QVec& a, const QVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
QVec cross(const QVec& a, const QVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A vector in [-1, 1] on each axis, times 2^exponent.
Vec3d vector_of(Random& random, int exponent) {
  Vec3d v;
  for (int a = 0; a < 3; ++a) {
    const double c = 2 * random.uniform() - 1;
    v[a] = std::ldexp(c, exponent);
  }
  return v;
}
int exponent_in(Random& random, int low, int high) {
  return low + static_cast<int>(random.below(static_cast<std::uint64_t>(high - low + 1)));
}

// The origin, two points on one line through it (up to rounding) at similar distances, and a third point
// whose squared distance underflows. |b - a| is 2^-1074 ... 2^-400, with the small point in each place.
TEST(Orient3d, AgreesWithRationalsWhereASquaredLengthUnderflows) {
  Random random(101);
  int signs[3] = {};
  for (int n = 0; n < test::repetitions(8000); ++n) {
    const int tiny = n % 2 ? exponent_in(random, -1074, -400) : exponent_in(random, -600, -530);
    const Vec3d b = vector_of(random, tiny), c = vector_of(random, 0);
    const double factor = 0.5 + random.uniform();
    std::array<Vec3d, 3> p{b, c, Vec3d{factor * c.x, factor * c.y, factor * c.z}};
    const std::uint64_t turn = random.below(3);
    std::rotate(p.begin(), p.begin() + static_cast<int>(turn), p.end());
    const int expected = test::orient3d_oracle({0, 0, 0}, p[0], p[1], p[2]);
    ASSERT_EQ(orient3d({0, 0, 0}, p[0], p[1], p[2]), expected) << "|b - a| about 2^" << tiny << ", " << n;
    ASSERT_EQ(orient3d(p[0], {0, 0, 0}, p[2], p[1]), expected) << "|b - a| about 2^" << tiny << ", " << n;
    ++signs[expected + 1];
  }
  EXPECT_GT(signs[0], test::repetitions(1000));
  EXPECT_GT(signs[2], test::repetitions(1000));
}

TEST(Orient3d, AgreesWithRationalsOverAllMagnitudesThatItAccepts) {
  Random random(102);
  for (int n = 0; n < test::repetitions(6000); ++n) {
    const Vec3d a = n % 3 ? Vec3d{} : vector_of(random, exponent_in(random, -1074, 190));
    const Vec3d b = vector_of(random, exponent_in(random, -1074, 190)),
                c = vector_of(random, exponent_in(random, -1074, 190));
    const double s = 2 * random.uniform() - 1, t = 2 * random.uniform() - 1;
    // In the plane of the others up to rounding. Every fourth point lies anywhere.
    const Vec3d d =
        n % 4 ? a + s * (b - a) + t * (c - a) : vector_of(random, exponent_in(random, -1074, 190));
    ASSERT_EQ(orient3d(a, b, c, d), test::orient3d_oracle(a, b, c, d)) << n;
  }
}

TEST(InSphere, AgreesWithRationalsOverAllMagnitudesThatItAccepts) {
  Random random(103);
  int asked = 0, signs[3] = {};
  for (int n = 0; n < test::repetitions(3000); ++n) {
    std::array<Vec3d, 5> p;
    if (n % 2) {  // on one sphere around the origin, up to an ulp
      const Vec3d v =
          vector_of(random, exponent_in(random, n % 4 == 1 ? -1074 : -400, n % 4 == 1 ? 190 : -150));
      for (Vec3d& r : p) {
        const std::uint64_t turn = random.below(3), flips = random.below(8);
        for (int axis = 0; axis < 3; ++axis) {
          const double c = v[static_cast<int>((axis + turn) % 3)];
          r[axis] = flips >> axis & 1 ? -c : c;
        }
      }
      p[4].x = std::nextafter(p[4].x, random.below(2) ? HUGE_VAL : -HUGE_VAL);
    } else {  // each with its own magnitude
      for (Vec3d& r : p) r = vector_of(random, exponent_in(random, -1074, n % 4 ? 190 : -200));
    }
    bool distinct = true;
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < i; ++j) distinct &= p[i] != p[j];
    const int orientation = test::orient3d_oracle(p[0], p[1], p[2], p[3]);
    if (!distinct || orientation == 0) continue;
    if (orientation < 0) std::swap(p[0], p[1]);
    ++asked;
    const int expected = test::in_sphere_oracle(p[0], p[1], p[2], p[3], p[4]);
    ASSERT_EQ(in_sphere(p[0], p[1], p[2], p[3], p[4]), expected) << n;
    ++signs[expected + 1];
  }
  EXPECT_GT(asked, test::repetitions(2000));
  EXPECT_GT(signs[0], test::repetitions(300));
  EXPECT_GT(signs[2], test::repetitions(300));
}

/// Small multiples of a power of two, with another power for each point or for each coordinate. Most
/// polynomials of such points have terms that underflow and others that do not.
Vec3d draw(Random& random) {
  constexpr int kExponents[] = {0, -1, -30, -170, -330, -540, -700, -1060, -1072, 38};
  const bool one = random.below(2) == 0;
  int exponent = kExponents[random.below(std::size(kExponents))];
  Vec3d p;
  for (int a = 0; a < 3; ++a) {
    if (!one) exponent = kExponents[random.below(std::size(kExponents))];
    const auto k = static_cast<double>(random.below(5)) - 2;
    p[a] = std::ldexp(k, exponent);
    if (random.below(4) == 0) p[a] = std::nextafter(p[a], random.below(2) ? HUGE_VAL : -HUGE_VAL);
  }
  return p;
}
std::vector<Vec3d> draw_distinct(Random& random, int n) {
  std::vector<Vec3d> points;
  while (static_cast<int>(points.size()) < n) {
    const Vec3d p = draw(random);
    if (std::find(points.begin(), points.end(), p) == points.end()) points.push_back(p);
  }
  return points;
}

/// n·x = d
struct Plane {
  QVec n;
  Rational d;
};
Plane bisector(const Vec3d& i, const Vec3d& j) {
  return {q(j) - q(i), (dot(q(j), q(j)) - dot(q(i), q(i))) / 2};
}
Plane plane_of(const std::vector<Vec3d>& t) {
  const QVec n = cross(q(t[1]) - q(t[0]), q(t[2]) - q(t[0]));
  return {n, dot(n, q(t[0]))};
}
Rational crossing(const Plane& a, const Plane& b, const Plane& c) { return dot(a.n, cross(b.n, c.n)); }
QVec intersection(const Plane& a, const Plane& b, const Plane& c) {
  return (1 / crossing(a, b, c)) * (a.d * cross(b.n, c.n) + b.d * cross(c.n, a.n) + c.d * cross(a.n, b.n));
}
int closer_to_first(const QVec& x, const Vec3d& i, const Vec3d& j) {
  const Rational difference = dot(x - q(j), x - q(j)) - dot(x - q(i), x - q(i));
  return difference.sign();
}

TEST(SidePredicates, AgreeWithRationalsWhereTheirPolynomialsUnderflow) {
  Random random(104);
  int side1s = 0, side2s = 0, side3s = 0, side4s = 0, crossings = 0, orders = 0;
  for (int n = 0; n < test::repetitions(2500); ++n) {
    const std::vector<Vec3d> s = draw_distinct(random, 5), t1 = draw_distinct(random, 3),
                             t2 = draw_distinct(random, 3);
    const Vec3d &i = s[0], &j = s[1];
    if (const int expected = closer_to_first(q(t1[0]), i, j)) {
      ++side1s;
      ASSERT_EQ(side1(i, j, t1[0]), expected) << n;
    }
    const Plane ij = bisector(i, j), ik = bisector(i, s[2]), il = bisector(i, s[3]), im = bisector(i, s[4]);
    if (side1(i, s[2], t1[0]) != side1(i, s[2], t1[1])) {
      const QVec a = q(t1[0]), e = q(t1[1]) - a;
      if (dot(ik.n, e) != 0) {
        const Rational t = (ik.d - dot(ik.n, a)) / dot(ik.n, e);
        if (const int expected = closer_to_first(a + t * e, i, j)) {
          ++side2s;
          ASSERT_EQ(side2(i, j, t1[0], t1[1], s[2]), expected) << n;
        }
      }
    }
    const Plane p1 = plane_of(t1), p2 = plane_of(t2);
    const int passes = crossing(p1, ik, il).sign();
    ASSERT_EQ(crossing_sign(t1[0], t1[1], t1[2], i, s[2], s[3]), passes) << n;
    crossings += passes != 0;
    if (passes != 0)
      if (const int expected = closer_to_first(intersection(p1, ik, il), i, j)) {
        ++side3s;
        ASSERT_EQ(side3(i, j, t1[0], t1[1], t1[2], s[2], s[3]), expected) << n;
      }
    if (crossing(ik, il, im) != 0)
      if (const int expected = closer_to_first(intersection(ik, il, im), i, j)) {
        ++side4s;
        ASSERT_EQ(side4(i, j, s[2], s[3], s[4]), expected) << n;
      }
    if (crossing(p1, ij, ik) != 0 && crossing(p2, ij, ik) != 0) {
      const Rational along = dot(cross(ij.n, ik.n), intersection(p1, ij, ik) - intersection(p2, ij, ik));
      if (along != 0) {
        ++orders;
        ASSERT_EQ(order_on_edge(i, j, s[2], {t1[0], t1[1], t1[2]}, {t2[0], t2[1], t2[2]}), along.sign()) << n;
      }
    }
  }
  for (const int asked : {side1s, side2s, side3s, side4s, crossings, orders})
    EXPECT_GT(asked, test::repetitions(400));
}

// The bound of a polynomial's value, for code that divides by it.
TEST(Approx, BoundsWhatUnderflowTakesAway) {
  Random random(105);
  for (int n = 0; n < test::repetitions(5000); ++n) {
    std::array<Approx, 6> x;
    std::array<Rational, 6> exact;
    for (int k = 0; k < 6; ++k) {
      const int exponent = exponent_in(random, -1074, 40);
      const double v = std::ldexp(2 * random.uniform() - 1, exponent);
      x[k] = v;
      exact[k] = Rational(v);
    }
    const auto polynomial = []<class T>(const std::array<T, 6>& v) -> T {
      return (v[0] * v[1] - v[2] * v[3]) * (v[4] * v[4] + v[5]) - v[1] * v[2] * v[3] * v[4];
    };
    const Approx value = polynomial(x);
    const Rational error = abs(polynomial(exact) - Rational(value.value));
    ASSERT_LE(error, Rational(value.bound())) << n;
    if (const int sign = value.certified_sign()) {
      ASSERT_EQ(sign, polynomial(exact).sign()) << n;
    }
  }
}

}  // namespace
}  // namespace fracture::exact
