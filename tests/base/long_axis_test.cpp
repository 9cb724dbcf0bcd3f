#include "common/base/long_axis.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fracture {
namespace {

/// A matrix with these eigenvalues along x, y and z, turned about (1, 1, 1) by a third of a turn and about z
/// by `angle`.
Matrix3 turned(const Vec3d& values, double angle, Vec3d (&axes)[3]) {
  const double c = std::cos(angle), s = std::sin(angle);
  axes[0] = {0, c, s};
  axes[1] = {0, -s, c};
  axes[2] = {1, 0, 0};
  Matrix3 m{{Vec3d{}, Vec3d{}, Vec3d{}}};
  for (int k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 3; ++i)
      m.rows[i] = m.rows[i] + values[k] * axes[k][static_cast<int>(i)] * axes[k];
  return m;
}

TEST(Axes, AreThoseOfTheLargestAndTheSmallestValue) {
  for (const double angle : {0.0, 0.3, 1.2}) {
    Vec3d axes[3];
    for (const Vec3d& values : {Vec3d{9, 4, 1}, Vec3d{9, 4, 1e-9}, Vec3d{9, 8.5, 0}}) {
      const Matrix3 m = turned(values, angle, axes);
      const auto longest = long_axis(m);
      ASSERT_TRUE(longest);
      EXPECT_NEAR(std::fabs(dot(longest->axis, axes[0])), 1, 1e-9);
      EXPECT_NEAR(longest->ratio, values.x / values.y, 1e-6);
      const auto shortest = short_axis(m);
      ASSERT_TRUE(shortest);
      EXPECT_NEAR(std::fabs(dot(shortest->axis, axes[2])), 1, 1e-9);
      EXPECT_NEAR(shortest->ratio, values.z / values.y, 1e-6);
    }
  }
}

TEST(Axes, OfNothingAreNone) {
  EXPECT_FALSE(long_axis(Matrix3{{Vec3d{}, Vec3d{}, Vec3d{}}}));
  EXPECT_FALSE(short_axis(Matrix3{{Vec3d{}, Vec3d{}, Vec3d{}}}));
}

}  // namespace
}  // namespace fracture
