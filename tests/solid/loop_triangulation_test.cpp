#include "common/mesh/loop_triangulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "common/base/random.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::solid_detail {
namespace {

/// Expects n - 2 triangles, with each side used once forward and each diagonal once in each direction.
void expect_disc(const std::vector<LoopTriangle>& triangles, std::size_t n) {
  ASSERT_EQ(triangles.size(), n - 2);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  for (const LoopTriangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const int count = ++directed[std::make_pair(t[k], t[(k + 1) % 3])];
      ASSERT_EQ(count, 1);
    }
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto j = static_cast<std::uint32_t>((i + 1) % n);
    ASSERT_EQ(directed.count({i, j}), 1u) << "side " << i;
    ASSERT_EQ(directed.count({j, i}), n == 2 ? 1u : 0u) << "side " << i;
    directed.erase({i, j});
  }
  for (const auto& [edge, count] : directed) {
    const std::pair<std::uint32_t, std::uint32_t> opposite{edge.second, edge.first};
    ASSERT_EQ(directed.count(opposite), 1u);
  }
}

double area_of(const std::vector<Vec3f>& corners, const std::vector<LoopTriangle>& triangles) {
  double area = 0;
  for (const LoopTriangle& t : triangles) {
    const Vec3d a = to_double(corners[t[0]]), b = to_double(corners[t[1]]), c = to_double(corners[t[2]]);
    area += 0.5 * length(cross(b - a, c - a));
  }
  return area;
}

/// A star-shaped polygon with n corners in a plane. Its radii vary at random.
std::vector<Vec3f> star(int n, std::uint64_t seed, int axis) {
  Random random(seed);
  std::vector<Vec3f> corners;
  for (int i = 0; i < n; ++i) {
    const test::CirclePoint p = test::circle_point(i, n);
    const double r = 0.2 + random.uniform();
    Vec3d q;
    q[axis] = 2;
    q[(axis + 1) % 3] = r * p.cos;
    q[(axis + 2) % 3] = r * p.sin;
    corners.push_back({static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)});
  }
  return corners;
}

double shoelace(const std::vector<Vec3f>& corners) {
  Vec3d sum;
  for (std::size_t i = 0; i < corners.size(); ++i)
    sum = sum + cross(to_double(corners[i]), to_double(corners[(i + 1) % corners.size()]));
  return 0.5 * std::fmax(std::fabs(sum.x), std::fmax(std::fabs(sum.y), std::fabs(sum.z)));
}

TEST(TriangulateLoop, CoversPlanarPolygonsOnceForBothMethodsAndAllAxes) {
  for (const int n : {3, 4, 5, 12, 28, 29, 60, 300, 3000})
    for (int axis = 0; axis < 3; ++axis)
      for (const bool backward : {false, true}) {
        SCOPED_TRACE(std::to_string(n) + " corners, axis " + std::to_string(axis));
        std::vector<Vec3f> corners = star(n, 100u + static_cast<unsigned>(n), axis);
        if (backward) std::reverse(corners.begin(), corners.end());
        const std::vector<LoopTriangle> triangles = triangulate_loop(corners, {});
        expect_disc(triangles, corners.size());
        // A triangulation without overlap has exactly the polygon's area. (The plane is at 2, and the
        // shoelace formula of the other two components ignores that.)
        std::vector<Vec3f> flat = corners;
        for (Vec3f& p : flat) (axis == 0 ? p.x : axis == 1 ? p.y : p.z) = 0;
        EXPECT_NEAR(area_of(corners, triangles), shoelace(flat), 1e-5 * shoelace(flat));
      }
}

TEST(TriangulateLoop, FollowsTheCornersOfASubdividedSquare) {
  std::vector<Vec3f> corners;
  constexpr int kN = 40;
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i < kN; ++i) {
      const float t = static_cast<float>(i) / kN;
      corners.push_back(side == 0   ? Vec3f{t, 0, 0}
                        : side == 1 ? Vec3f{1, t, 0}
                        : side == 2 ? Vec3f{1 - t, 1, 0}
                                    : Vec3f{0, 1 - t, 0});
    }
  const std::vector<LoopTriangle> triangles = triangulate_loop(corners, {});
  expect_disc(triangles, corners.size());
  EXPECT_NEAR(area_of(corners, triangles), 1, 1e-6);
}

TEST(TriangulateLoop, AnyLoopInSpaceBecomesADisc) {
  Random random(5);
  for (const std::size_t n : {3u, 7u, 28u, 29u, 100u, 1000u, 20000u}) {
    std::vector<Vec3f> corners(n);
    for (Vec3f& p : corners) {
      p.x = static_cast<float>(random.uniform());
      p.y = static_cast<float>(random.uniform());
      p.z = static_cast<float>(random.uniform());
    }
    expect_disc(triangulate_loop(corners, {}), n);
    for (Vec3f& p : corners) p = {0, 0, 0};
    expect_disc(triangulate_loop(corners, {}), n);
    for (std::size_t i = 0; i < n; ++i) corners[i] = {static_cast<float>(i), 0, 0};
    expect_disc(triangulate_loop(corners, {}), n);
  }
}

}  // namespace
}  // namespace fracture::solid_detail
