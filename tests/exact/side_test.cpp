// Compares the Voronoi side predicates with rational arithmetic with explicit weights. The k-th site in
// lexicographic order weighs 2^(-300 (k + 1)). That is small compared with anything that integer coordinates
// below 2^20 can produce. The oracle constructs the point as a rational number and compares power distances.
// It contains no polynomial of the code under test.
#include "common/exact/side.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <vector>

#include "common/base/random.hpp"
#include "common/exact/in_sphere.hpp"
#include "common/exact/orient3d.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::exact {
namespace {

using Q = boost::multiprecision::cpp_rational;
using QVec = std::array<Q, 3>;

QVec q(const Vec3d& p) { return {Q(p.x), Q(p.y), Q(p.z)}; }
QVec operator-(const QVec& a, const QVec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
QVec operator+(const QVec& a, const QVec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
QVec operator*(const Q& s, const QVec& a) { return {s * a[0], s * a[1], s * a[2]}; }
Q dot(const QVec& a, const QVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
QVec cross(const QVec& a, const QVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
int sign(const Q& v) { return v.sign(); }

/// The weighted sites of one question.
class Oracle {
 public:
  explicit Oracle(std::vector<Vec3d> sites) : sites_(std::move(sites)) {
    std::sort(sites_.begin(), sites_.end(),
              [](const Vec3d& a, const Vec3d& b) { return fracture::lexicographic_less(a, b); });
  }

  Q weight(const Vec3d& s) const {
    const auto rank = std::find(sites_.begin(), sites_.end(), s) - sites_.begin();
    return Q(1, boost::multiprecision::cpp_int(1) << static_cast<unsigned>(300 * (rank + 1)));
  }
  Q power(const QVec& x, const Vec3d& s) const { return dot(x - q(s), x - q(s)) - weight(s); }
  int closer_to_first(const QVec& x, const Vec3d& i, const Vec3d& j) const {
    return sign(power(x, j) - power(x, i));
  }

  /// The (weighted) bisector of i and j as n·x = d.
  void bisector(const Vec3d& i, const Vec3d& j, QVec& n, Q& d) const {
    n = q(j) - q(i);
    d = (dot(q(j), q(j)) - weight(j) - dot(q(i), q(i)) + weight(i)) / 2;
  }
  static bool intersect(const std::array<QVec, 3>& n, const std::array<Q, 3>& d, QVec& x) {
    const Q det = dot(n[0], cross(n[1], n[2]));
    if (det == 0) return false;
    x = (1 / det) * (d[0] * cross(n[1], n[2]) + d[1] * cross(n[2], n[0]) + d[2] * cross(n[0], n[1]));
    return true;
  }

 private:
  std::vector<Vec3d> sites_;
};

/// Small integers make nearly every configuration degenerate. The ulp family moves points around one point by
/// single ulps.
Vec3d draw(Random& random, int family) {
  Vec3d p;
  for (int a = 0; a < 3; ++a) {
    const auto k = static_cast<double>(random.below(4));
    if (family == 0) {
      p[a] = k;
    } else {
      p[a] = 1 + k * 0.25;
      const auto ulps = static_cast<int>(random.below(3)) - 1;
      if (ulps != 0) p[a] = std::nextafter(p[a], ulps > 0 ? 100.0 : -100.0);
    }
  }
  return p;
}

std::vector<Vec3d> draw_distinct(Random& random, int family, int n) {
  std::vector<Vec3d> points;
  while (static_cast<int>(points.size()) < n) {
    const Vec3d p = draw(random, family);
    if (std::find(points.begin(), points.end(), p) == points.end()) points.push_back(p);
  }
  return points;
}

class SidePredicates : public testing::TestWithParam<int> {};

TEST_P(SidePredicates, Side1AgreesWithWeightedRationals) {
  Random random(11);
  for (int n = 0; n < test::repetitions(4000); ++n) {
    const auto s = draw_distinct(random, GetParam(), 2);
    const Vec3d x = draw(random, GetParam());
    EXPECT_EQ(side1(s[0], s[1], x), Oracle(s).closer_to_first(q(x), s[0], s[1]));
  }
}

TEST_P(SidePredicates, Side2AgreesWithWeightedRationals) {
  Random random(12);
  int asked = 0;
  for (int n = 0; n < test::repetitions(6000); ++n) {
    const auto s = draw_distinct(random, GetParam(), 3);
    const Vec3d &i = s[0], &j = s[1], &k = s[2];
    const auto ends = draw_distinct(random, GetParam(), 2);
    const Oracle oracle(s);
    if (side1(i, k, ends[0]) == side1(i, k, ends[1])) continue;  // no crossing, so nothing to compare
    QVec normal;
    Q d;
    oracle.bisector(i, k, normal, d);
    const QVec e = q(ends[1]) - q(ends[0]);
    const Q t = (d - dot(normal, q(ends[0]))) / dot(normal, e);
    ++asked;
    EXPECT_EQ(side2(i, j, ends[0], ends[1], k), oracle.closer_to_first(q(ends[0]) + t * e, i, j));
  }
  EXPECT_GT(asked, test::repetitions(500));
}

TEST_P(SidePredicates, Side3AgreesWithWeightedRationals) {
  Random random(13);
  int asked = 0;
  for (int n = 0; n < test::repetitions(3000); ++n) {
    const auto s = draw_distinct(random, GetParam(), 4);
    const auto t = draw_distinct(random, GetParam(), 3);
    const Oracle oracle(s);
    std::array<QVec, 3> normals;
    std::array<Q, 3> d;
    oracle.bisector(s[0], s[2], normals[0], d[0]);
    oracle.bisector(s[0], s[3], normals[1], d[1]);
    normals[2] = cross(q(t[1]) - q(t[0]), q(t[2]) - q(t[0]));
    d[2] = dot(normals[2], q(t[0]));
    QVec x;
    if (!Oracle::intersect(normals, d, x)) continue;
    ++asked;
    EXPECT_EQ(side3(s[0], s[1], t[0], t[1], t[2], s[2], s[3]), oracle.closer_to_first(x, s[0], s[1]));
    EXPECT_EQ(crossing_sign(t[0], t[1], t[2], s[0], s[2], s[3]),
              sign(dot(normals[2], cross(normals[0], normals[1]))));
  }
  EXPECT_GT(asked, test::repetitions(500));
}

TEST_P(SidePredicates, Side4AgreesWithWeightedRationalsAndWithInSphere) {
  Random random(14);
  int asked = 0;
  for (int n = 0; n < test::repetitions(3000); ++n) {
    const auto s = draw_distinct(random, GetParam(), 5);
    const Oracle oracle(s);
    std::array<QVec, 3> normals;
    std::array<Q, 3> d;
    for (int m = 0; m < 3; ++m) oracle.bisector(s[0], s[2 + m], normals[m], d[m]);
    QVec x;
    if (!Oracle::intersect(normals, d, x)) continue;
    ++asked;
    const int side = side4(s[0], s[1], s[2], s[3], s[4]);
    EXPECT_EQ(side, oracle.closer_to_first(x, s[0], s[1]));
    const bool positive = orient3d(s[0], s[2], s[3], s[4]) > 0;
    const int conflict =
        positive ? in_sphere(s[0], s[2], s[3], s[4], s[1]) : in_sphere(s[0], s[2], s[4], s[3], s[1]);
    EXPECT_EQ(side, -conflict) << "inside the sphere of the others means closer to j";
  }
  EXPECT_GT(asked, test::repetitions(500));
}

TEST_P(SidePredicates, OrderOnEdgeAgreesWithWeightedRationals) {
  Random random(15);
  int asked = 0, ties = 0;
  for (int n = 0; n < test::repetitions(3000); ++n) {
    const auto s = draw_distinct(random, GetParam(), 3);
    const Oracle oracle(s);
    const QVec direction = cross(q(s[1]) - q(s[0]), q(s[2]) - q(s[0]));
    QVec x[2];
    Triangle t[2];
    bool transversal = true;
    for (int m = 0; m < 2; ++m) {
      const auto c = draw_distinct(random, GetParam(), 3);
      t[m] = {c[0], c[1], c[2]};
      std::array<QVec, 3> normals;
      std::array<Q, 3> d;
      oracle.bisector(s[0], s[1], normals[0], d[0]);
      oracle.bisector(s[0], s[2], normals[1], d[1]);
      normals[2] = cross(q(c[1]) - q(c[0]), q(c[2]) - q(c[0]));
      d[2] = dot(normals[2], q(c[0]));
      transversal &= Oracle::intersect(normals, d, x[m]);
    }
    if (!transversal) continue;
    ++asked;
    const int expected = sign(dot(direction, x[0] - x[1]));
    const int order = order_on_edge(s[0], s[1], s[2], t[0], t[1]);
    EXPECT_EQ(order, expected);
    EXPECT_EQ(order_on_edge(s[0], s[1], s[2], t[1], t[0]), -expected);
    if (expected == 0) {
      ++ties;  // only the same plane ties
      EXPECT_EQ(orient3d(t[0].a, t[0].b, t[0].c, t[1].a), 0);
      EXPECT_EQ(orient3d(t[0].a, t[0].b, t[0].c, t[1].b), 0);
      EXPECT_EQ(orient3d(t[0].a, t[0].b, t[0].c, t[1].c), 0);
    }
  }
  EXPECT_GT(asked, test::repetitions(300));
  if (GetParam() == 0) {
    EXPECT_GT(ties, 0) << "the family does contain coplanar triangles";
  }
}

INSTANTIATE_TEST_SUITE_P(Families, SidePredicates, testing::Values(0, 1),
                         [](const auto& i) { return i.param == 0 ? "IntegerGrid" : "UlpGrid"; });

TEST(SidePredicates, NeverReturnZeroOnExactTies) {
  const Vec3d i{0, 0, 0}, j{2, 0, 0}, k{0, 2, 0}, l{0, 0, 2};
  EXPECT_EQ(side1(i, j, {1, 5, 7}), 1) << "the lexicographically smaller site is heavier";
  EXPECT_EQ(side1(j, i, {1, 5, 7}), -1);
  EXPECT_NE(side2(i, j, {1, 0, 3}, {1, 2, 3}, k), 0);
  EXPECT_NE(side3(i, j, {1, 0, 0}, {1, 4, 0}, {1, 0, 4}, k, l), 0);
}

TEST(SidePredicates, WideExponentRangeOfExportedCosines) {
  // Exporters write cos 90° as 6.1e-17, here next to coordinates near 1000: a range of about 80 bits.
  const double c = 6.123233995736766e-17;
  const Vec3d i{0, c, 1000}, j{2, -c, 1000}, x{1, c, 999.5}, y{1, 1000, c};
  EXPECT_EQ(side1(i, j, x), Oracle({i, j}).closer_to_first(q(x), i, j));
  EXPECT_EQ(side1(i, j, y), Oracle({i, j}).closer_to_first(q(y), i, j));
  const Vec3d k{c, 3, 1000};
  ASSERT_NE(side1(i, k, {c, 0, c}), side1(i, k, {c, 4, 1000}));
  EXPECT_NE(side2(i, j, {c, 0, c}, {c, 4, 1000}, k), 0);
}

}  // namespace
}  // namespace fracture::exact
