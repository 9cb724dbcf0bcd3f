#include "common/solid/float_predicates.hpp"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>

#include "common/base/random.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::solid_detail {
namespace {

using Rational = boost::multiprecision::cpp_rational;

int sign_of(const Rational& r) { return r > 0 ? 1 : r < 0 ? -1 : 0; }

int rational_orient2d(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
  const Rational ax(a.x), ay(a.y), bx(b.x), by(b.y), cx(c.x), cy(c.y);
  return sign_of((bx - ax) * (cy - ay) - (by - ay) * (cx - ax));
}

int rational_orient3d(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  const Rational u[3] = {Rational(b.x) - Rational(a.x), Rational(b.y) - Rational(a.y),
                         Rational(b.z) - Rational(a.z)};
  const Rational v[3] = {Rational(c.x) - Rational(a.x), Rational(c.y) - Rational(a.y),
                         Rational(c.z) - Rational(a.z)};
  const Rational w[3] = {Rational(d.x) - Rational(a.x), Rational(d.y) - Rational(a.y),
                         Rational(d.z) - Rational(a.z)};
  return sign_of(u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) +
                 u[2] * (v[0] * w[1] - v[1] * w[0]));
}

float step(float value, int ulps) {
  for (; ulps > 0; --ulps) value = std::nextafter(value, HUGE_VALF);
  for (; ulps < 0; ++ulps) value = std::nextafter(value, -HUGE_VALF);
  return value;
}

TEST(SignOrient2d, AgreesWithRationalsOnAnUlpGridAroundCollinearPoints) {
  const Vec2f a{0.5f, 0.5f}, b{12.f, 12.f};
  for (int i = -8; i <= 8; ++i)
    for (int j = -8; j <= 8; ++j) {
      const Vec2f c{step(24.f, i), step(24.f, j)};
      ASSERT_EQ(sign_orient2d(a, b, c), rational_orient2d(a, b, c)) << i << " " << j;
    }
}

TEST(SignOrient3d, AgreesWithRationalsOnAnUlpGridAroundACoplanarPoint) {
  const Vec3f a{0.1f, 0.2f, 0.3f}, b{1.7f, 0.2f, 0.3f}, c{0.1f, 3.9f, 0.3f};
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j)
      for (int k = -3; k <= 3; ++k) {
        const Vec3f d{step(0.7f, i), step(0.9f, j), step(0.3f, k)};
        ASSERT_EQ(sign_orient3d(a, b, c, d), rational_orient3d(a, b, c, d));
      }
}

TEST(SignOrient3d, AgreesWithRationalsForCoordinatesOfWildlyDifferentSize) {
  Random random(17);
  const auto draw = [&] {
    const double mantissa = 2 * random.uniform() - 1;
    const int exponent = static_cast<int>(random.below(80)) - 40;
    return static_cast<float>(std::ldexp(mantissa, exponent));
  };
  for (int i = 0; i < test::repetitions(500); ++i) {
    Vec3f p[4];
    for (Vec3f& q : p) {
      q.x = draw();
      q.y = draw();
      q.z = draw();
    }
    if (i % 3 == 0) p[3] = p[random.below(3)];
    if (i % 5 == 0) p[3].z = p[2].z = p[1].z = p[0].z;
    ASSERT_EQ(sign_orient3d(p[0], p[1], p[2], p[3]), rational_orient3d(p[0], p[1], p[2], p[3])) << i;
    const Vec2f a{p[0].x, p[0].y}, b{p[1].x, p[1].y}, c{p[2].x, p[2].y};
    ASSERT_EQ(sign_orient2d(a, b, c), rational_orient2d(a, b, c)) << i;
  }
}

TEST(ExactSum, KeepsWhatDoublesLose) {
  ExactSum sum;
  sum.add(1e300);
  sum.add(1e-300);
  sum.add(-1e300);
  EXPECT_EQ(sum.sign(), 1);
  EXPECT_EQ(sum.estimate(), 1e-300);
  sum.add(-1e-300);
  EXPECT_EQ(sum.sign(), 0);
}

}  // namespace
}  // namespace fracture::solid_detail
