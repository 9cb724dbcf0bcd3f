#include "common/rough/surface_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "common/base/random.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

Vec3d point_around(const Box& box, Random& random) {
  Vec3d p;
  for (int a = 0; a < 3; ++a) p[a] = box.min[a] + (1.2 * random.uniform() - 0.1) * box.size()[a];
  return p;
}

TEST(DistanceToTriangle, KnowsCornersEdgesAndTheFace) {
  const Vec3d a{0, 0, 0}, b{4, 0, 0}, c{0, 4, 0};
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, 1, -3}, a, b, c), 3);
  EXPECT_DOUBLE_EQ(distance_to_triangle({-3, -4, 0}, a, b, c), 5);
  EXPECT_DOUBLE_EQ(distance_to_triangle({7, 0, 4}, a, b, c), 5);
  EXPECT_DOUBLE_EQ(distance_to_triangle({2, -3, 4}, a, b, c), 5);
  EXPECT_DOUBLE_EQ(distance_to_triangle({4, 4, 0}, a, b, c), std::sqrt(8));
  EXPECT_DOUBLE_EQ(distance_to_triangle({0, 9, 0}, a, b, c), 5);
  EXPECT_DOUBLE_EQ(distance_to_triangle({5, 0, 0}, a, a, b), 1) << "a flat one";
}

TEST(SurfaceTree, DistanceIsThatOfTheNearestTriangleUpToTheMost) {
  Pacer pacer(kUninterrupted);
  for (const Mesh& mesh : {torus(24, 12), box({0, 0, 0}, {3, 0.1, 2}, 2), tetrahedron()}) {
    const Solid solid = *make_solid(std::make_shared<Mesh>(mesh), {}, {});
    const SurfaceTree surface(solid);
    for (const double reach : {0.02, 0.3, 10.0}) {
      Random random(5);
      for (int n = 0; n < 300; ++n) {
        const Vec3d p = point_around(solid.box, random);
        double least = reach;
        for (std::uint32_t t = 0; t < solid.triangles.size(); ++t) {
          const auto [a, b, c] = surface.corners(t);
          least = std::min(least, distance_to_triangle(p, a, b, c));
        }
        EXPECT_NEAR(surface.distance(p, reach, pacer), least, 1e-12);
      }
    }
  }
}

TEST(SurfaceTree, MissesNoTriangleThatMeetsABox) {
  const Solid solid = *make_solid(std::make_shared<Mesh>(torus(24, 12)), {}, {});
  const SurfaceTree surface(solid);
  Random random(6);
  for (int n = 0; n < 200; ++n) {
    // A small box around a point of a triangle.
    const auto t = static_cast<std::uint32_t>(random.below(solid.triangles.size()));
    const auto [a, b, c] = surface.corners(t);
    const double u = random.uniform(), v = (1 - u) * random.uniform();
    const Vec3d p = a + u * (b - a) + v * (c - a), half{0.01, 0.01, 0.01};
    std::set<std::uint32_t> seen;
    surface.each_near({p - half, p + half}, [&](std::uint32_t other) { seen.insert(other); });
    EXPECT_TRUE(seen.contains(t));
    EXPECT_LT(seen.size(), solid.triangles.size() / 4);
  }
}

}  // namespace
}  // namespace fracture::test
