#include "common/physics/hull_overlap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/random.hpp"
#include "common/physics/convex_hull.hpp"

namespace fracture::test {
namespace {

using Corners = std::vector<Vec3d>;

/// Three steps of the grid, of hulls together a few metres long.
constexpr double kGrid = 3e-5;

Corners box_corners(const Vec3d& low, const Vec3d& high) {
  Corners points;
  for (int k = 0; k < 8; ++k)
    points.push_back({k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z});
  return points;
}

Corners moved_corners(Corners points, const Vec3d& by) {
  for (Vec3d& p : points) p = p + by;
  return points;
}

/// The unit cube about the origin, turned by 45° about an axis.
Corners turned_cube(int axis) {
  const double s = std::sqrt(0.5);
  Corners points;
  for (Vec3d p : box_corners({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5})) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const double x = p[u], y = p[v];
    p[u] = s * (x - y);
    p[v] = s * (x + y);
    points.push_back(p);
  }
  return points;
}

HullDepth measure(const Corners& a, const Corners& b) {
  const Execution execution;
  Pacer pacer(execution);
  HullOverlap overlap;
  const HullDepth there = overlap.measure(a, b, pacer), back = overlap.measure(b, a, pacer);
  EXPECT_NEAR(std::fmax(there.depth, 0), std::fmax(back.depth, 0), kGrid);
  return there;
}

void expect_near(const Vec3d& a, const Vec3d& b) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], 1e-4) << k;
}

const Corners kCube = box_corners({0, 0, 0}, {1, 1, 1});

TEST(HullOverlap, OfBoxesIsTheLeastOfTheThreeAxes) {
  const HullDepth x = measure(kCube, moved_corners(kCube, {0.7, 0.1, -0.2}));
  EXPECT_NEAR(x.depth, 0.3, kGrid);
  expect_near(x.normal, {1, 0, 0});
  const HullDepth z = measure(kCube, moved_corners(kCube, {0.7, 0.8, -0.9}));
  EXPECT_NEAR(z.depth, 0.1, kGrid);
  expect_near(z.normal, {0, 0, -1});
}

TEST(HullOverlap, TouchingIsNoneAndAMillionthApartIsApart) {
  EXPECT_NEAR(measure(kCube, moved_corners(kCube, {1, 0, 0})).depth, 0, kGrid);
  EXPECT_NEAR(measure(kCube, moved_corners(kCube, {1 + 1e-6, 0, 0})).depth, -1e-6, 1e-9);
  EXPECT_LT(measure(kCube, moved_corners(kCube, {1.5, 1.5, 1.5})).depth, -0.1);
}

TEST(HullOverlap, OfTheSameCubeAndOfOneInside) {
  EXPECT_NEAR(measure(kCube, kCube).depth, 1, kGrid);
  EXPECT_NEAR(measure(kCube, box_corners({0.4, 0.4, 0.4}, {0.6, 0.6, 0.6})).depth, 0.6, kGrid);
  // Nearer to the side -y: it leaves the cube there, by 0.1 + 0.2.
  const HullDepth out = measure(kCube, box_corners({0.4, 0.1, 0.4}, {0.6, 0.3, 0.6}));
  EXPECT_NEAR(out.depth, 0.3, kGrid);
  expect_near(out.normal, {0, -1, 0});
}

TEST(HullOverlap, OfATurnedCubeIsMeasuredToItsEdge) {
  // Its edges are half of the diagonal from its middle.
  const Corners turned = moved_corners(turned_cube(2), {1 + std::sqrt(0.5) - 0.2, 0.5, 0.5});
  const HullDepth found = measure(kCube, turned);
  EXPECT_NEAR(found.depth, 0.2, kGrid);
  expect_near(found.normal, {1, 0, 0});
}

TEST(HullOverlap, OfTwoCrossedEdgesIsAlongTheirCommonNormal) {
  // An edge along z at x = sqrt(1/2), and one along y at x = 2 sqrt(1/2) - 0.1 - sqrt(1/2). No face is that near.
  const HullDepth found =
      measure(turned_cube(2), moved_corners(turned_cube(1), {std::sqrt(2.0) - 0.1, 0, 0}));
  EXPECT_NEAR(found.depth, 0.1, kGrid);
  expect_near(found.normal, {1, 0, 0});
}

TEST(HullOverlap, OfTetrahedraBetweenTheirSlantedFaces) {
  const Corners corner{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Corners opposite;
  for (const Vec3d& p : corner) opposite.push_back(Vec3d{0.6, 0.6, 0.6} - p);
  // x + y + z is at most 1 in the one, and at least 3 * 0.6 - 1 in the other.
  EXPECT_NEAR(measure(corner, opposite).depth, 0.2 / std::sqrt(3.0), kGrid);
}

TEST(HullOverlap, FarFromTheOriginAsNearIt) {
  const Vec3d far{1e5, -2e5, 3e5};
  EXPECT_NEAR(measure(moved_corners(kCube, far), moved_corners(kCube, far + Vec3d{0.7, 0, 0})).depth, 0.3,
              kGrid);
}

TEST(HullOverlap, FlatOrSmallHullsAreNoTrouble) {
  const Corners sheet = box_corners({0, 0, 0.5}, {1, 1, 0.5}), point{{0.5, 0.5, 0.25}};
  EXPECT_NEAR(measure(kCube, sheet).depth, 0.5, kGrid);
  EXPECT_NEAR(measure(kCube, point).depth, 0.25, kGrid);
  EXPECT_LE(measure(sheet, sheet).depth, kGrid);
  EXPECT_LE(measure(point, point).depth, kGrid);
  EXPECT_LT(measure(point, sheet).depth, 0);
}

/// By all normals of faces and all cross products of edges.
double depth_by_separating_axes(const std::array<Corners, 2>& hulls,
                                const std::array<std::vector<std::array<std::uint32_t, 3>>, 2>& triangles) {
  std::vector<Vec3d> axes;
  std::array<std::vector<Vec3d>, 2> edges;
  for (std::size_t h = 0; h < 2; ++h)
    for (const auto& t : triangles[h]) {
      const Vec3d &a = hulls[h][t[0]], &b = hulls[h][t[1]], &c = hulls[h][t[2]];
      axes.push_back(cross(b - a, c - a));
      for (const Vec3d& edge : {b - a, c - b, a - c}) edges[h].push_back(edge);
    }
  for (const Vec3d& x : edges[0])
    for (const Vec3d& y : edges[1]) axes.push_back(cross(x, y));
  double least = HUGE_VAL;
  for (const Vec3d& axis : axes) {
    if (length(axis) < 1e-9) continue;
    const Vec3d n = (1 / length(axis)) * axis;
    std::array<double, 2> low{HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL};
    for (std::size_t h = 0; h < 2; ++h)
      for (const Vec3d& p : hulls[h]) {
        low[h] = std::fmin(low[h], dot(n, p));
        high[h] = std::fmax(high[h], dot(n, p));
      }
    least = std::fmin(least, std::fmin(high[0] - low[1], high[1] - low[0]));
  }
  return least;
}

TEST(HullOverlap, AgreesWithAllSeparatingAxes) {
  Random random(20261129);
  int apart = 0;
  for (int round = 0; round < 300; ++round) {
    std::array<Corners, 2> hulls;
    std::array<std::vector<std::array<std::uint32_t, 3>>, 2> triangles;
    const double distance = 2 * random.uniform();
    for (std::size_t h = 0; h < 2; ++h) {
      std::vector<Vec3f> points;
      for (int k = 0; k < 4 + round % 9; ++k)
        points.push_back({static_cast<float>(random.uniform() + (h == 1 ? distance : 0)),
                          static_cast<float>(random.uniform()), static_cast<float>(random.uniform())});
      ConvexHullBuilder builder;
      triangles[h] = builder.build(points, 255);
      for (const Vec3f& p : points) hulls[h].push_back(to_double(p));
    }
    if (triangles[0].empty() || triangles[1].empty()) continue;
    const double expected = depth_by_separating_axes(hulls, triangles),
                 found = measure(hulls[0], hulls[1]).depth;
    if (expected > 0) {
      EXPECT_NEAR(found, expected, kGrid) << round;
      EXPECT_GE(found, expected - 1e-12) << round;
    } else {
      ++apart;
      EXPECT_LE(found, kGrid) << round;
    }
  }
  EXPECT_GT(apart, 50);
}

}  // namespace
}  // namespace fracture::test
