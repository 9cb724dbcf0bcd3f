#include "common/rough/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/random.hpp"

namespace fracture {
namespace {

Vec3d random_point(Random& random) {
  const double x = 40 * random.uniform() - 20, y = 40 * random.uniform() - 20, z = 40 * random.uniform() - 20;
  return {x, y, z};
}

TEST(GradientNoise, IsBoundedAndItsSlopeToo) {
  Random random(1);
  double most = 0, steepest = 0;
  constexpr double kStep = 1e-5;
  for (int n = 0; n < 100'000; ++n) {
    const Vec3d p = random_point(random);
    const std::uint64_t seed = random.below(4);
    const Vec3d here = gradient_noise(p, seed);
    const Vec3d x = gradient_noise({p.x + kStep, p.y, p.z}, seed) - here,
                y = gradient_noise({p.x, p.y + kStep, p.z}, seed) - here,
                z = gradient_noise({p.x, p.y, p.z + kStep}, seed) - here;
    for (int a = 0; a < 3; ++a) {
      most = std::fmax(most, std::fabs(here[a]));
      steepest = std::fmax(steepest, length(Vec3d{x[a], y[a], z[a]}) / kStep);
    }
  }
  EXPECT_LE(most, kNoiseBound);
  EXPECT_GT(most, 0.7) << "uses its range";
  EXPECT_LE(steepest, kNoiseSlope);
  EXPECT_GT(steepest, 1.5);
}

TEST(GradientNoise, VanishesAtTheLatticeAndIsContinuousAcrossCells) {
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y) EXPECT_EQ(gradient_noise({1.0 * x, 1.0 * y, 3}, 7), Vec3d{});
  Random random(2);
  for (int n = 0; n < 1000; ++n) {
    Vec3d p = random_point(random);
    p.x = std::floor(p.x);
    EXPECT_LT(length(gradient_noise({p.x - 1e-9, p.y, p.z}, 3) - gradient_noise(p, 3)), 1e-8);
  }
}

TEST(GradientNoise, SeedsAndComponentsAreIndependent) {
  Random random(3);
  double seeds = 0, components = 0, squares = 0;
  for (int n = 0; n < 20'000; ++n) {
    const Vec3d p = random_point(random);
    const Vec3d a = gradient_noise(p, 1), b = gradient_noise(p, 2);
    seeds += a.x * b.x;
    components += a.x * a.y;
    squares += a.x * a.x;
  }
  EXPECT_LT(std::fabs(seeds), 0.05 * squares);
  EXPECT_LT(std::fabs(components), 0.05 * squares);
}

}  // namespace
}  // namespace fracture
