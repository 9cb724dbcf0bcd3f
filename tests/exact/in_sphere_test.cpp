#include "common/exact/in_sphere.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "common/base/random.hpp"
#include "common/exact/orient3d.hpp"
#include "tests/exact/rational_oracle.hpp"
#include "tests/exact/ulps.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::exact {
namespace {

using test::in_sphere_oracle;
using test::ulps;

// Puts the tetrahedron in positive order. Returns false if it is flat or two of the five points coincide.
bool make_positive(std::array<Vec3d, 5>& p) {
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < i; ++j)
      if (p[i] == p[j]) return false;
  const int sign = orient3d(p[0], p[1], p[2], p[3]);
  if (sign < 0) std::swap(p[2], p[3]);
  return sign != 0;
}

int call(const std::array<Vec3d, 5>& p) { return in_sphere(p[0], p[1], p[2], p[3], p[4]); }
int oracle(const std::array<Vec3d, 5>& p) { return in_sphere_oracle(p[0], p[1], p[2], p[3], p[4]); }

TEST(InSphere, IsPositiveInside) {
  const Vec3d a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0}, d{0, 0, 1};
  EXPECT_EQ(in_sphere(a, b, c, d, {0.25, 0.25, 0.25}), 1);
  EXPECT_EQ(in_sphere(a, b, c, d, {0.99, 0.99, 0.99}), 1);
  EXPECT_EQ(in_sphere(a, b, c, d, {1.01, 1.01, 1.01}), -1);
  EXPECT_EQ(in_sphere(a, b, c, d, {-5, 0, 0}), -1);
}

TEST(InSphere, AgreesWithRationalsOnUlpGridAroundCosphericalPoint) {
  // Five corners of a box with coordinates in thirds: cospherical up to rounding, and exactly so for some
  // points of the grid.
  const double s = 1.0 / 3, t = 2.0 / 3;
  std::array<Vec3d, 5> p{Vec3d{s, s, s}, Vec3d{t, s, s}, Vec3d{s, t, s}, Vec3d{s, s, t}, Vec3d{t, t, t}};
  ASSERT_TRUE(make_positive(p));
  const Vec3d e = p[4];
  int inside = 0, outside = 0;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j)
      for (int k = -4; k <= 4; ++k) {
        p[4] = {ulps(e.x, i), ulps(e.y, j), ulps(e.z, k)};
        const int expected = oracle(p);
        ASSERT_EQ(call(p), expected) << i << " " << j << " " << k;
        (expected > 0 ? inside : outside)++;
      }
  EXPECT_GT(inside, 0);
  EXPECT_GT(outside, 0);
}

// Small lattices: nearly everything is cospherical and much is coplanar, so every branch of the tie rule is
// used.
TEST(InSphere, FollowsTheTieRuleOnLatticesAsWithExplicitInfinitesimalWeights) {
  Random random(17);
  int ties = 0;
  for (const double divisor : {1.0, 3.0, 21.0})
    for (int i = 0; i < test::repetitions(1500); ++i) {
      std::array<Vec3d, 5> p;
      for (Vec3d& q : p)
        for (int axis = 0; axis < 3; ++axis) q[axis] = static_cast<double>(random.below(3)) / divisor;
      if (!make_positive(p)) continue;
      PredicateCounters counters;
      in_sphere_exact(p[0], p[1], p[2], p[3], p[4], {}, &counters);
      ties += static_cast<int>(counters.ties);
      const int expected = oracle(p);
      ASSERT_NE(expected, 0);
      ASSERT_EQ(call(p), expected) << "divisor " << divisor << ", " << i;
    }
  EXPECT_GT(ties, test::repetitions(300));
}

TEST(InSphere, AgreesWithRationalsForCoordinatesOfEveryWidthAndRange) {
  Random random(23);
  for (const int bits : {3, 9, 11, 12, 19, 20, 21, 23, 24, 25, 40, 53, 60})
    for (int i = 0; i < test::repetitions(120); ++i) {
      // Without rounding, these points lie on a common sphere: one vector with changed signs and exchanged
      // axes, shifted.
      std::array<Vec3d, 5> p;
      const Vec3d v{std::floor(random.uniform() * std::ldexp(1.0, bits)),
                    std::floor(random.uniform() * std::ldexp(1.0, bits)),
                    std::floor(random.uniform() * std::ldexp(1.0, bits))};
      for (Vec3d& q : p) {
        const std::uint64_t turn = random.below(3), signs = random.below(8);
        for (int axis = 0; axis < 3; ++axis) {
          const double c = v[static_cast<int>((axis + turn) % 3)];
          q[axis] = signs >> axis & 1 ? -c : c;
        }
      }
      if (i % 3 == 0) p[4].x = ulps(p[4].x, 1);
      if (i % 3 == 1) p[4].y += 1;
      if (!make_positive(p)) continue;
      ASSERT_EQ(call(p), oracle(p)) << bits << " bits, " << i;
    }
  for (int i = 0; i < test::repetitions(600); ++i) {
    std::array<Vec3d, 5> p;
    for (Vec3d& q : p)
      for (int axis = 0; axis < 3; ++axis) {
        const double v = static_cast<double>(random.below(5)) - 2;
        const std::uint64_t kind = random.below(4);
        q[axis] = kind == 0 ? v * 6.1e-17 : kind == 1 ? v * 1e12 : kind == 2 ? v * 5e-324 : v;
      }
    if (!make_positive(p)) continue;
    ASSERT_EQ(call(p), oracle(p)) << i;
  }
}

TEST(InSphere, DoesNotDependOnTheOrderOfTheTetrahedronsVertices) {
  Random random(29);
  for (int i = 0; i < test::repetitions(300); ++i) {
    std::array<Vec3d, 5> p;
    for (Vec3d& q : p)
      for (int axis = 0; axis < 3; ++axis) q[axis] = static_cast<double>(random.below(3)) / 21;
    if (!make_positive(p)) continue;
    const int expected = call(p);
    std::array<int, 4> order{0, 1, 2, 3};
    do {
      const std::array<Vec3d, 5> q{p[order[0]], p[order[1]], p[order[2]], p[order[3]], p[4]};
      if (orient3d(q[0], q[1], q[2], q[3]) > 0) {
        ASSERT_EQ(call(q), expected);
      }
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

// If two tetrahedra share a facet, either both are locally Delaunay against each other's vertex, or neither
// is.
TEST(InSphere, IsSymmetricAcrossAFacet) {
  Random random(31);
  int seen = 0;
  for (int i = 0; i < test::repetitions(3000); ++i) {
    std::array<Vec3d, 5> p;
    for (Vec3d& q : p)
      for (int axis = 0; axis < 3; ++axis) q[axis] = static_cast<double>(random.below(3));
    if (!make_positive(p)) continue;
    if (orient3d(p[0], p[1], p[2], p[4]) >= 0) continue;  // e on the far side of abc
    ++seen;
    ASSERT_EQ(call(p), in_sphere(p[0], p[2], p[1], p[4], p[3]));
  }
  EXPECT_GT(seen, test::repetitions(300));
}

TEST(InSphere, TheSharedScaleOfAPointSetGivesTheSameAnswers) {
  Random random(37);
  for (int i = 0; i < test::repetitions(300); ++i) {
    std::array<Vec3d, 5> p;
    BinaryScale scale;
    for (Vec3d& q : p) {
      for (int axis = 0; axis < 3; ++axis) q[axis] = static_cast<double>(random.below(22)) / 21;
      scale.include(q);
    }
    scale.include(Vec3d{4.5, -3.5, 2});
    if (!make_positive(p)) continue;
    ASSERT_TRUE(scale.fits());
    ASSERT_EQ(in_sphere_exact(p[0], p[1], p[2], p[3], p[4], scale), oracle(p));
  }
}

}  // namespace
}  // namespace fracture::exact
