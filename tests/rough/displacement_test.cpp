#include "common/rough/displacement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/random.hpp"

namespace fracture {
namespace {

Vec3d point_in_unit_cube(Random& random) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return {x, y, z};
}

TEST(Displacement, StaysWithinTheAmplitudeAndUsesMuchOfIt) {
  const Displacement displacement(0.02, 8, 3, 1, {}, 0);
  Random random(1);
  double most = 0;
  for (int n = 0; n < 50'000; ++n) {
    const Vec3d d = displacement.at(point_in_unit_cube(random), displacement.reach());
    for (int a = 0; a < 3; ++a) most = std::fmax(most, std::fabs(d[a]));
  }
  EXPECT_LE(most, 0.02);
  EXPECT_GT(most, 0.01);
}

TEST(Displacement, FadesToNothingAtTheSurfaceAndNeverReachesIt) {
  const Displacement displacement(0.02, 8, 1, 1, {}, 0);
  Random random(2);
  for (int n = 0; n < 20'000; ++n) {
    const Vec3d p = point_in_unit_cube(random);
    const double surface = displacement.reach() * random.uniform();
    EXPECT_LT(length(displacement.at(p, surface)), std::fmax(surface, 1e-300));
    EXPECT_EQ(displacement.at(p, 0), Vec3d{});
  }
}

TEST(Displacement, NothingMovesNearerToTheSurfaceThanIsSaid) {
  const Displacement displacement(0.02, 8, 1, 1, {}, 0.1);
  EXPECT_NEAR(displacement.reach(), 0.1 + Displacement::fading(0.02), 1e-12);
  Random random(5);
  for (int n = 0; n < 1000; ++n) {
    const Vec3d p = point_in_unit_cube(random);
    EXPECT_EQ(displacement.at(p, 0.1 * random.uniform()), Vec3d{});
    // Beyond this distance, the displacement fades as if a surface lay there. Far away it is undiminished.
    EXPECT_LT(length(displacement.at(p, 0.1 + 1e-6)), 2e-6);
    EXPECT_EQ(displacement.at(p, 1), Displacement(0.02, 8, 1, 1, {}, 0).at(p, 1));
  }
}

TEST(Displacement, AMapStretchesTheWavesButShortensNone) {
  // The displacement is the same across the grain and eight times as long along it. Points move four times as
  // far along it.
  const Matrix3 map{{Vec3d{3, 0, 0}, Vec3d{0, 3, 0}, Vec3d{0, 0, 3.0 / 8}}};
  const Displacement plain(0.01, 5, 1, 4, {}, 0), stretched(0.01, 5, 1, 4, map, 0);
  Random random(3);
  for (int n = 0; n < 1000; ++n) {
    const Vec3d p = point_in_unit_cube(random), q{p.x, p.y, 8 * p.z};
    Vec3d far = plain.at(p, 10);  // from any surface
    far.z *= 4;
    EXPECT_LT(length(far - stretched.at(q, 10)), 1e-12);
  }
}

TEST(Displacement, WithoutOneGrainItIsTheSameInAllDirections) {
  const double c = std::cos(0.5), s = std::sin(0.5);
  for (const Matrix3& map : {Matrix3{{Vec3d{c, s, 0}, Vec3d{-s, c, 0}, Vec3d{0, 0, 1}}},    // turned
                             Matrix3{{Vec3d{1, 0, 0}, Vec3d{0, 2, 0}, Vec3d{0, 0, 1}}}}) {  // flat cells
    const Displacement displacement(0.02, 8, 3, 1, map, 0);
    Random random(4);
    Vec3d most;
    for (int n = 0; n < 50'000; ++n) {
      const Vec3d d = displacement.at(point_in_unit_cube(random), displacement.reach());
      for (int a = 0; a < 3; ++a) most[a] = std::fmax(most[a], std::fabs(d[a]));
    }
    for (int a = 0; a < 3; ++a) {
      EXPECT_LE(most[a], 0.02);
      EXPECT_GT(most[a], 0.008);
    }
  }
}

// Fibres move points four times as far, but only along the grain.
TEST(Displacement, NothingMovesFartherThanIsSaidInAnyDirection) {
  const double c = std::cos(0.5), s = std::sin(0.5);
  const Matrix3 turned{{Vec3d{c, s, 0}, Vec3d{-s, c, 0}, Vec3d{0, 0, 1.0 / 8}}},
      along_a_diagonal{{Vec3d{c / 8, s / 8, 0}, Vec3d{-s, c, 0}, Vec3d{0, 0, 1}}};
  for (const CellMap& map : {CellMap(), CellMap(turned), CellMap(along_a_diagonal)})
    for (const std::uint32_t octaves : {1u, 3u}) {
      const Displacement displacement(0.02, 8, octaves, 1, map, 0);
      ASSERT_EQ(displacement.frames(), 1u);
      const Movement most = displacement.most();
      EXPECT_EQ(most.further, map ? 3 : 0);
      Random random(6);
      double farthest = 0;
      for (int n = 0; n < 50'000; ++n) {
        const Vec3d d = displacement.at(point_in_unit_cube(random), displacement.reach());
        const Vec3d normal = point_in_unit_cube(random) - Vec3d{0.5, 0.5, 0.5};
        farthest = std::fmax(farthest, length(d));
        EXPECT_LE(std::fabs(dot(d, normal)), most.along(normal));
      }
      EXPECT_LE(farthest, most.distance());
      EXPECT_GT(farthest, 0.2 * most.distance());
    }
}

}  // namespace
}  // namespace fracture
