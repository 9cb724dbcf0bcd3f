#include "common/hollow/inner_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/hollow/deep_points.hpp"
#include "common/hollow/lattice.hpp"
#include "tests/hollow/expect_closed.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::hollow_detail {
namespace {

struct Part {
  SurfaceTree tree;
  Box box;
};

Part part_of(const Mesh& mesh, const Vec3d& shift = {}) {
  std::vector<std::array<Vec3d, 3>> triangles;
  Box box;
  for (const auto& t : mesh.triangles) {
    auto& corners = triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) box.add(corners[k] = to_double(mesh.positions[t[k]]) + shift);
  }
  return {SurfaceTree(std::move(triangles)), box};
}

Vec3d corner(const InnerSurface& s, std::size_t t, std::size_t k) {
  return to_double(s.positions[s.triangles[t][k]]);
}

/// Measures at 66 points of each triangle, or at 21 points in short tests.
double least_depth(const InnerSurface& s, const SurfaceTree& tree) {
  Pacer pacer(kUninterrupted);
  double least = HUGE_VAL;
  const int step = test::sized(2, 1);
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    for (int i = 0; i <= 10; i += step)
      for (int j = 0; i + j <= 10; j += step)
        least = std::fmin(least, tree.distance(i / 10.0 * corner(s, t, 0) + j / 10.0 * corner(s, t, 1) +
                                                   (10 - i - j) / 10.0 * corner(s, t, 2),
                                               HUGE_VAL, pacer));
  return least;
}

/// Positive if the triangles face the enclosed volume.
double enclosed(const InnerSurface& s, const Vec3d& origin = {}) {
  double six = 0;
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    six -= dot(corner(s, t, 0) - origin, cross(corner(s, t, 1) - origin, corner(s, t, 2) - origin));
  return six / 6;
}

TEST(InnerSurface, OfABallIsABall) {
  const Part ball = part_of(test::ico_sphere(4));
  const InnerSurface s = inner_surface(ball.tree, ball.box, 0.1, {}, {});
  expect_closed(s);
  EXPECT_GE(least_depth(s, ball.tree), 0.1);
  const double full = 4 * std::numbers::pi / 3 * 0.9 * 0.9 * 0.9;
  EXPECT_LT(enclosed(s), full);
  // With 20,000 triangles the lattice has steps of a sixteenth. Corners lie 0.118 deep or up to a sixteenth
  // of an edge deeper, and more is lost between them.
  EXPECT_GT(enclosed(s), 0.8 * full);
  if (test::short_tests()) return;
  EXPECT_GT(enclosed(inner_surface(ball.tree, ball.box, 0.1, {200'000, 200'000, 1u << 21}, {})), 0.93 * full);
}

TEST(InnerSurface, KeepsItsDistanceFromReflexEdges) {
  // If the outside bends inwards, the points between two sufficiently deep points are less deep.
  const Part star = part_of(test::menger_sponge(1));
  for (const double thickness : {0.05, 0.08, 0.12}) {
    const InnerSurface s = inner_surface(star.tree, star.box, thickness, {}, {});
    expect_closed(s);
    ASSERT_FALSE(s.triangles.empty());
    EXPECT_GE(least_depth(s, star.tree), thickness);
  }
}

TEST(InnerSurface, OfARingIsARing) {
  const Part ring = part_of(test::torus(64, 32));
  const InnerSurface s = inner_surface(ring.tree, ring.box, 0.1, {}, {});
  expect_closed(s);
  EXPECT_EQ(s.positions.size(), s.triangles.size() / 2) << "vertices - edges + faces = 0: genus 1";
  EXPECT_NEAR(enclosed(s), 2 * std::numbers::pi * std::numbers::pi * 0.3 * 0.3, 0.75);
}

TEST(InnerSurface, StaysWithinItsLimitByBeingCoarser) {
  const Part ball = part_of(test::ico_sphere(3));
  const InnerSurface s = inner_surface(ball.tree, ball.box, 0.02, {.triangles = 2000}, {});
  expect_closed(s);
  EXPECT_LE(s.triangles.size(), 2000u);
  EXPECT_GT(s.triangles.size(), 100u);
  EXPECT_GE(least_depth(s, ball.tree), 0.02);
}

TEST(InnerSurface, SaysWithWhichLimitsAnotherWouldCome) {
  const Part ball = part_of(test::ico_sphere(3));
  for (const InnerSurfaceLimits& limits : {InnerSurfaceLimits{.triangles = 20'000, .marched = 3000},
                                           InnerSurfaceLimits{.triangles = 400, .marched = 20'000}}) {
    InnerSurfaceLimits other;
    const InnerSurface s = inner_surface(ball.tree, ball.box, 0.02, limits, {}, &other);
    const auto with = [&](std::uint32_t triangles, std::uint32_t marched) {
      return inner_surface(ball.tree, ball.box, 0.02, {triangles, marched}, {}).triangles;
    };
    const std::uint32_t below = std::min(other.triangles - 1, 30'000u),
                        marched = std::min(other.marched - 1, 30'000u);
    EXPECT_EQ(with(below, marched), s.triangles) << "below both";
    const bool by_marched = other.marched < other.triangles;
    EXPECT_NE(with(by_marched ? below : other.triangles, by_marched ? other.marched : marched), s.triangles);
  }
}

TEST(InnerSurface, OfAWallThinnerThanNumbersAreEnds) {
  const Part ball = part_of(test::ico_sphere(2));
  for (const double thickness : {5e-324, 1e-323, 1e-300, 1e-12})
    expect_closed(inner_surface(ball.tree, ball.box, thickness, {.triangles = 2000}, {}));
}

TEST(InnerSurface, IsNotWhereNothingIsDeepEnough) {
  const Part ball = part_of(test::ico_sphere(3));
  EXPECT_TRUE(inner_surface(ball.tree, ball.box, 0.99, {}, {}).triangles.empty());
  EXPECT_TRUE(inner_surface(ball.tree, ball.box, 5, {}, {}).triangles.empty());
  const Part plate = part_of(test::thin_plate());
  EXPECT_TRUE(inner_surface(plate.tree, plate.box, 0.01, {}, {}).triangles.empty());
}

TEST(InnerSurface, IsClosedFarFromTheOrigin) {
  const Part ball = part_of(test::ico_sphere(3), {5000, -3000, 3});
  const InnerSurface s = inner_surface(ball.tree, ball.box, 0.1, {}, {});
  expect_closed(s);
  EXPECT_GE(least_depth(s, ball.tree), 0.1);
}

TEST(InnerSurface, IsTheSameForAnyNumberOfThreads) {
  const Part ring = part_of(test::torus(32, 16));
  const InnerSurface one = inner_surface(ring.tree, ring.box, 0.1, {}, {});
  const InnerSurface four = inner_surface(ring.tree, ring.box, 0.1, {}, {.threads = 4});
  EXPECT_EQ(one.positions, four.positions);
  EXPECT_EQ(one.triangles, four.triangles);
}

TEST(DeepPoints, AreThoseThatEachIsAskedFor) {
  const Part ball = part_of(test::ico_sphere(3), {7, -2, 1});
  const Part ring = part_of(test::torus(32, 16));
  Pacer pacer(kUninterrupted);
  for (const Part* part : {&ball, &ring})
    for (const double depth : {0.11, 0.29}) {
      const Lattice lattice(part->box, 0.0625);
      const std::vector<std::uint8_t> deep = deep_points(part->tree, lattice, depth, 1, {.threads = 2});
      ASSERT_EQ(deep.size(), lattice.points());
      for (std::uint32_t p = 0; p < lattice.points(); ++p) {
        const Vec3d place = lattice.place(p), from_middle = place - part->box.center();
        const double from_circle = std::hypot(std::hypot(from_middle.x, from_middle.y) - 1, from_middle.z);
        const bool inside = part == &ball ? length(from_middle) < 1 : from_circle < 0.4;
        ASSERT_EQ(deep[p] != 0, inside && !part->tree.within(place, depth, pacer)) << p;
      }
    }
}

TEST(HoldsBall, WhatIsLargerIsSeenAndNothingSmaller) {
  const Part ball = part_of(test::ico_sphere(4), {3, 1, 0});
  EXPECT_TRUE(holds_ball(ball.tree, ball.box, 0.99 / 1.06, {}));
  EXPECT_FALSE(holds_ball(ball.tree, ball.box, 1.01, {}));
  const Part ring = part_of(test::torus(64, 32));  // 0.4 thick on each side of its circle
  EXPECT_TRUE(holds_ball(ring.tree, ring.box, 0.395 / 1.06, {}));
  EXPECT_FALSE(holds_ball(ring.tree, ring.box, 0.41, {})) << "its hole is outside";
  // The result must hold for any position of the lattice of points.
  for (int k = 0; k < test::sized(2, 8); ++k) {
    const double low = 0.03 * k;
    const Part slab = part_of(test::box({low, 0, 0}, {low + 0.4, 3, 2 + low}));
    EXPECT_TRUE(holds_ball(slab.tree, slab.box, 0.2 / 1.06, {})) << k;
    EXPECT_FALSE(holds_ball(slab.tree, slab.box, 0.2001, {})) << k;
  }
  const Part plate = part_of(test::thin_plate());
  EXPECT_FALSE(holds_ball(plate.tree, plate.box, 0.1 * plate.box.longest_side(), {}));
}

}  // namespace
}  // namespace fracture::hollow_detail
