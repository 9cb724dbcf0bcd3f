// Volumes of needles. For these, sums in doubles keep no correct digit.
#include "common/exact/volume_sum.hpp"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <vector>

#include "common/base/random.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::exact {
namespace {

using Rational = boost::multiprecision::cpp_rational;
using Triangle = std::array<Vec3d, 3>;

/// Six times the volume, exactly.
Rational six_volumes(const std::vector<Triangle>& surface) {
  Rational six = 0;
  for (const auto& [a, b, c] : surface)
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      six += Rational(a[k]) * (Rational(b[i]) * Rational(c[j]) - Rational(b[j]) * Rational(c[i]));
    }
  return six;
}

struct Sums {
  double plain = 0, precise = 0;
  bool cancels = false;
};
Sums sums_of(const std::vector<Triangle>& surface) {
  const Vec3d origin = surface[0][0];
  VolumeSum precise(origin);
  double six = 0, products = 0, size = 0;
  for (const auto& [a, b, c] : surface) {
    precise.add(a, b, c);
    six += dot(a - origin, cross(b - a, c - a));
    products += max_norm(b - a) * max_norm(c - a);
    size = std::fmax(size, max_norm(a - origin));
  }
  return {six / 6, precise.volume(), cancels(six / 6, products, size)};
}

std::vector<Triangle> tetrahedron(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return {{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}};
}

TEST(VolumeSum, IsRightWhereTheSumInDoublesSaysThatItCancels) {
  Random random(11);
  int cancelling = 0, wrong = 0;
  for (int n = 0; n < test::repetitions(2000); ++n) {
    // Four points near a line or, every other time, near a plane. Both are oblique, so that no coordinate is
    // 0.
    const double thin = std::ldexp(1.0, -static_cast<int>(random.below(n % 2 ? 22 : 45)));
    std::array<Vec3d, 4> p;
    for (Vec3d& v : p) {
      const double along = random.uniform(), across = (n % 2 ? thin : 1.0) * random.uniform();
      const Vec3d noise{random.uniform(), random.uniform(), random.uniform()};
      v = along * Vec3d{0.31, 0.73, 0.59} + across * Vec3d{0.67, -0.37, 0.11} + thin * noise;
    }
    const std::vector<Triangle> surface = tetrahedron(p[0], p[1], p[2], p[3]);
    const Rational six = six_volumes(surface);
    if (six == 0) continue;
    const double exact = static_cast<double>(six) / 6;
    const Sums sums = sums_of(surface);
    EXPECT_NEAR(sums.precise, exact, 1e-15 * std::fabs(exact)) << n;
    if (!sums.cancels) {
      EXPECT_NEAR(sums.plain, exact, 1e-10 * std::fabs(exact)) << n;
    }
    cancelling += sums.cancels;
    wrong += std::fabs(sums.plain - exact) > 1e-10 * std::fabs(exact);
  }
  EXPECT_GT(wrong, test::repetitions(2000) / 40) << "some have to be hard";
  EXPECT_GE(cancelling, wrong);
  EXPECT_LT(cancelling, test::repetitions(1600)) << "and some easy";
}

TEST(VolumeSum, AnEmptySurfaceHasNone) { EXPECT_EQ(VolumeSum({1, 2, 3}).volume(), 0); }

}  // namespace
}  // namespace fracture::exact
