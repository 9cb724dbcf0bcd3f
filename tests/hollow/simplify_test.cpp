#include "common/hollow/simplify.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/hollow/expect_closed.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::hollow_detail {
namespace {

InnerSurface inner_side(const Mesh& mesh) {
  InnerSurface s;
  s.positions = mesh.positions;
  for (const auto& [a, b, c] : mesh.triangles) s.triangles.push_back({a, c, b});  // faces the inside
  return s;
}

SurfaceTree tree_of(const std::vector<Vec3f>& positions,
                    const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<std::array<Vec3d, 3>> corners;
  for (const auto& [a, b, c] : triangles)
    corners.push_back({to_double(positions[a]), to_double(positions[b]), to_double(positions[c])});
  return SurfaceTree(std::move(corners));
}
SurfaceTree tree_of(const Mesh& mesh) { return tree_of(mesh.positions, mesh.triangles); }

const SurfaceTree& far_away() {
  static const SurfaceTree tree = tree_of(test::scaled(test::cube(), {100, 100, 100}));
  return tree;
}

/// The largest distance of corners of one surface from the triangles of another.
double farthest(const InnerSurface& from, const InnerSurface& to) {
  const SurfaceTree tree = tree_of(to.positions, to.triangles);
  Pacer pacer(kUninterrupted);
  double most = 0;
  for (const Vec3f& p : from.positions) most = std::fmax(most, tree.distance(to_double(p), HUGE_VAL, pacer));
  return most;
}

TEST(Simplified, FlatSidesHaveTheTrianglesThatTheyNeed) {
  const InnerSurface fine = inner_side(test::cube(8));
  const InnerSurface s = simplified(fine, 1e-6, far_away(), 1, {});
  expect_closed(s);
  EXPECT_EQ(s.triangles.size(), 12u);
  EXPECT_EQ(s.positions.size(), 8u);
  EXPECT_LT(farthest(fine, s), 1e-5);
}

TEST(Simplified, WhatIsRoundStaysWithinTheTolerance) {
  const InnerSurface fine = inner_side(test::ico_sphere(4));
  for (const double tolerance : {0.006, 0.02}) {
    const InnerSurface s = simplified(fine, tolerance, far_away(), 1, {});
    expect_closed(s);
    EXPECT_LT(3 * s.triangles.size(), fine.triangles.size());
    EXPECT_LT(farthest(fine, s), 3 * tolerance);
    EXPECT_LT(farthest(s, fine), 1e-6) << "no corner is new";
    EXPECT_FALSE(crosses_itself(s, {}));
  }
}

TEST(Simplified, ARingKeepsItsHole) {
  const InnerSurface s = simplified(inner_side(test::torus(64, 32)), 0.03, far_away(), 1, {});
  expect_closed(s);
  EXPECT_LT(s.triangles.size(), 1000u);
  EXPECT_EQ(2 * s.positions.size(), s.triangles.size()) << "vertices - edges + faces = 0: genus 1";
}

TEST(Simplified, ComesNoNearerToTheOutside) {
  // In its hole, the ring bends away from its axis. With fewer triangles it gets closer to the rod there.
  const InnerSurface fine = inner_side(test::torus(64, 32));
  const SurfaceTree rod = tree_of(test::box({-0.3, -0.3, -1}, {0.3, 0.3, 1}));
  const double as_it_was = 0.6 - 0.3 * std::numbers::sqrt2;  // at the corners of the rod
  ASSERT_TRUE(is_deep(fine, rod, 0.97 * as_it_was, {}));
  const InnerSurface free = simplified(fine, 0.05, far_away(), 1, {});
  EXPECT_FALSE(is_deep(free, rod, 0.97 * as_it_was, {}));
  const InnerSurface held = simplified(fine, 0.05, rod, 0.97 * as_it_was, {});
  EXPECT_TRUE(is_deep(held, rod, 0.9 * as_it_was, {}));
  EXPECT_LT(2 * held.triangles.size(), fine.triangles.size());
}

TEST(IsDeep, ProvesAndDenies) {
  const SurfaceTree ball = tree_of(test::ico_sphere(4));
  const InnerSurface inner = inner_side(test::ico_sphere(3, 0.8));
  EXPECT_TRUE(is_deep(inner, ball, 0.19, {}));
  EXPECT_FALSE(is_deep(inner, ball, 0.21, {}));
}

TEST(IsDeep, ProvesItOfLargeTrianglesWithLittleToSpare) {
  // A proof by middles alone would need four thousand of them along an edge.
  const SurfaceTree cube = tree_of(test::cube(2));
  const InnerSurface inner = inner_side(test::scaled(test::cube(), {0.75, 0.75, 0.75}));
  EXPECT_TRUE(is_deep(inner, cube, 0.125 - 1e-4, {}));
  EXPECT_FALSE(is_deep(inner, cube, 0.125 + 1e-4, {}));
}

TEST(IsDeep, SeesWhatComesNearBetweenCornersAndMiddles) {
  const InnerSurface inner = inner_side(test::cube());
  const auto spike = [](double top) {
    return tree_of({{0.2f, 0.1f, static_cast<float>(top)}, {0.21f, 0.1f, 3}, {0.2f, 0.11f, 3}}, {{0, 1, 2}});
  };
  EXPECT_TRUE(is_deep(inner, spike(0.61), 0.1, {}));
  EXPECT_FALSE(is_deep(inner, spike(0.59), 0.1, {}));
  EXPECT_FALSE(is_deep(inner, spike(-3), 0.1, {})) << "right through";
}

TEST(CrossesItself, WhereTwoTrianglesDo) {
  EXPECT_FALSE(crosses_itself(inner_side(test::ico_sphere(2)), {}));
  const Mesh apart = test::translated(test::tetrahedron(), {10, 0, 0});
  EXPECT_FALSE(crosses_itself(inner_side(test::joined({test::tetrahedron(), apart})), {}));
  const Mesh in = test::translated(test::tetrahedron(), {0.2, 0.1, 0.05});
  EXPECT_TRUE(crosses_itself(inner_side(test::joined({test::tetrahedron(), in})), {}));
}

}  // namespace
}  // namespace fracture::hollow_detail
