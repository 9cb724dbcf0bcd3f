#include "common/bvh/surface_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "common/base/random.hpp"
#include "common/bvh/triangle_distance.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

std::vector<std::array<Vec3d, 3>> corners_of(const Mesh& mesh) {
  std::vector<std::array<Vec3d, 3>> corners;
  for (const auto& [a, b, c] : mesh.triangles)
    corners.push_back(
        {to_double(mesh.positions[a]), to_double(mesh.positions[b]), to_double(mesh.positions[c])});
  return corners;
}

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
    const SurfaceTree surface(corners_of(mesh));
    Box around;
    for (const Vec3f& p : mesh.positions) around.add(to_double(p));
    for (const double reach : {0.02, 0.3, HUGE_VAL}) {
      Random random(5);
      for (int n = 0; n < 300; ++n) {
        const Vec3d p = point_around(around, random);
        double least = reach;
        for (const auto& [a, b, c] : surface.corners())
          least = std::min(least, distance_to_triangle(p, a, b, c));
        EXPECT_NEAR(surface.distance(p, reach, pacer), least, 1e-12);
        EXPECT_FALSE(surface.within(p, 0.999 * least, pacer));
        EXPECT_EQ(surface.within(p, 1.001 * least, pacer), least < reach);
      }
    }
  }
}

TEST(SurfaceTree, KnowsWhetherItIsNearATriangle) {
  Pacer pacer(kUninterrupted);
  Random random(7);
  int within = 0, beyond = 0;
  for (const Mesh& mesh : {torus(24, 12), box({0, 0, 0}, {3, 0.1, 2}, 2), tetrahedron()}) {
    const SurfaceTree surface(corners_of(mesh));
    Box around;
    for (const Vec3f& p : mesh.positions) around.add(to_double(p));
    for (int n = 0; n < 300; ++n) {
      const Vec3d a = point_around(around, random), b = a + 0.1 * point_around(around, random),
                  c = a + 0.1 * point_around(around, random);
      const std::array<Vec3d, 3> triangle{a, b, c};
      const bool expected =
          std::any_of(surface.corners().begin(), surface.corners().end(),
                      [&](const std::array<Vec3d, 3>& t) { return are_within(triangle, t, 0.08); });
      double least = 0.5;
      for (const std::array<Vec3d, 3>& t : surface.corners())
        least = std::min(least, distance_of_triangles(triangle, t, 0.5));
      EXPECT_NEAR(surface.distance_of(triangle, 0.5, pacer), least, 1e-12) << n;
      const std::optional<bool> said = surface.near_triangle(triangle, 0.08, pacer);
      if (said) {
        EXPECT_EQ(*said, expected) << n;
        ++(expected ? within : beyond);
      } else {
        EXPECT_GT(surface.triangles(), SurfaceTree::kMostAsked);
      }
    }
  }
  EXPECT_GT(within, 50);
  EXPECT_GT(beyond, 50);
  const auto flat = [](double z) -> std::array<Vec3d, 3> { return {{{0, 0, z}, {1, 0, z}, {0, 1, z}}}; };
  const SurfaceTree many(std::vector<std::array<Vec3d, 3>>(SurfaceTree::kMostAsked + 1, flat(0)));
  EXPECT_FALSE(many.near_triangle(flat(0.1), 1, pacer).has_value());
  EXPECT_EQ(many.near_triangle(flat(2), 1, pacer), false);
}

TEST(SurfaceTree, MissesNoTriangleThatMeetsABox) {
  const SurfaceTree surface(corners_of(torus(24, 12)));
  Random random(6);
  for (int n = 0; n < 200; ++n) {
    // Makes a small box around a point of a triangle.
    const auto t = static_cast<std::uint32_t>(random.below(surface.triangles()));
    const auto [a, b, c] = surface.corners(t);
    const double u = random.uniform(), v = (1 - u) * random.uniform();
    const Vec3d p = a + u * (b - a) + v * (c - a), half{0.01, 0.01, 0.01};
    std::set<std::uint32_t> seen;
    surface.each_near({p - half, p + half}, [&](std::uint32_t other) { seen.insert(other); });
    EXPECT_TRUE(seen.contains(t));
    EXPECT_LT(seen.size(), surface.triangles() / 4);
  }
}

TEST(SurfaceTree, OfNothingIsInfinitelyFar) {
  Pacer pacer(kUninterrupted);
  const SurfaceTree nothing({});
  EXPECT_EQ(nothing.distance({0, 0, 0}, HUGE_VAL, pacer), HUGE_VAL);
  EXPECT_FALSE(nothing.within({0, 0, 0}, 1e9, pacer));
}

TEST(SurfaceTree, FindsTrianglesWithoutAreaFromAnywhere) {
  Pacer pacer(kUninterrupted);
  const Vec3d a{1, 2, 3};
  const SurfaceTree point({{a, a, a}});
  EXPECT_EQ(point.distance({1, 2, 8}, HUGE_VAL, pacer), 5);
}

}  // namespace
}  // namespace fracture::test
