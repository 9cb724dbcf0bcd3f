// Several hulls for one solid: how many, how much larger than the solid, what they cover and what they leave open.
#include "common/physics/convex_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stop_token>
#include <string>
#include <thread>

#include "tests/physics/bent_shapes.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/poll_gaps.hpp"

namespace fracture::test {
namespace {

ConvexParts parts_of(const Mesh& mesh, const HullLimits& limits = {1.5, 8}, const Execution& execution = {}) {
  return make_convex_parts(mesh.positions, mesh.triangles, limits, execution);
}

double volume_of_hull(const CollisionHull& hull) {
  Mesh mesh;
  mesh.positions = hull.points;
  mesh.triangles = hull.triangles;
  return volume_of(mesh);
}

/// From p to the segment, and from p to the triangle (Ericson 2005, 5.1.5, by its edges and its inside).
double distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const double t = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
  return length(p - (a + t * (b - a)));
}
double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d n = cross(b - a, c - a);
  double least =
      std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
  if (dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 &&
      dot(cross(a - c, p - c), n) >= 0)
    least = std::min(least, std::fabs(dot(n, p - a)) / length(n));
  return least;
}

/// From p to the hull; 0 inside.
double distance_to(const CollisionHull& hull, const Vec3d& p) {
  double least = HUGE_VAL;
  bool is_outside = false;
  for (const auto& t : hull.triangles) {
    const Vec3d a = to_double(hull.points[t[0]]), b = to_double(hull.points[t[1]]),
                c = to_double(hull.points[t[2]]);
    is_outside = is_outside || dot(cross(b - a, c - a), p - a) > 0;
    least = std::min(least, distance_to_triangle(p, a, b, c));
  }
  return is_outside ? least : 0;
}

/// From p to the nearest of the hulls: the largest sphere about p that touches none.
double free_radius(const ConvexParts& parts, const Vec3d& p) {
  double least = HUGE_VAL;
  for (const CollisionHull& hull : parts.hulls) least = std::min(least, distance_to(hull, p));
  return least;
}

/// [-1, 1]² less [-w, w]², 2 d thick: volume 8 d (1 - w²), and of the hull 8 d.
Mesh square_frame(double w, double d, int n = 1) {
  return grid_solid(
      {{{-1, -w, w, 1}, {-1, -w, w, 1}, {-d, d}}}, [](int i, int j, int) { return i != 1 || j != 1; }, n);
}
Mesh l_shape() {  // area 0.51, of the hull 1 - 0.7² / 2
  return grid_solid(
      {{{0, 0.3, 1}, {0, 0.3, 1}, {0, 0.3}}}, [](int i, int j, int) { return i == 0 || j == 0; }, 2);
}
Mesh u_shape() {  // area 0.72, of the hull 1
  return grid_solid(
      {{{0, 0.3, 0.7, 1}, {0, 0.3, 1}, {0, 0.3}}}, [](int i, int j, int) { return i != 1 || j == 0; }, 2);
}
Mesh arch() {  // half a ring about the z axis, y >= 0
  return round_solid({0.7, 1}, 32, {0, 0.4}, [](int, int j, int) { return j < 16; });
}
Mesh mug() {  // inside 0.88 wide from 0.15 up; the handle on the sector from 0 to 22.5 degrees
  return round_solid({0, 0.88, 1, 1.4, 1.6}, 16, {0, 0.15, 0.5, 0.7, 1.5, 1.7, 2}, [](int i, int j, int k) {
    if (i == 0) return k == 0;
    if (i == 1) return true;
    return j == 0 && (i == 2 ? k == 2 || k == 4 : k >= 2 && k <= 4);
  });
}
Mesh lattice() {  // four posts and three rails, 0.1 thick
  return grid_solid({{{0, 0.1, 1, 1.1, 2, 2.1, 3, 3.1}, {0, 0.1, 1, 1.1, 2, 2.1}, {0, 0.1}}},
                    [](int i, int j, int) { return i % 2 == 0 || j % 2 == 0; });
}

std::vector<NamedMesh> bent_shapes() {
  return {{"frame", square_frame(0.8, 0.05)},
          {"frame of 576", square_frame(0.8, 0.05, 3)},
          {"L", l_shape()},
          {"U", u_shape()},
          {"thin ring", torus(24, 12, 1, 0.1)},
          {"ring", torus(24, 12)},
          {"arch", arch()},
          {"mug", mug()},
          {"lattice", lattice()},
          {"sponge", menger_sponge(1)},
          {"box", box({0, 0, 0}, {1, 2, 3}, 3)},
          {"sphere", sphere_with(500)},
          {"plate", thin_plate()}};
}

TEST(BentShapes, AreClosedAndHaveTheVolumesOfTheirCells) {
  for (const NamedMesh& shape : bent_shapes()) EXPECT_EQ(open_directed_edges(shape.mesh), 0u) << shape.name;
  EXPECT_NEAR(volume_of(square_frame(0.8, 0.05, 3)), 0.4 * 0.36, 1e-7);
  EXPECT_EQ(square_frame(0.8, 0.05, 3).triangles.size(), 576u);
  EXPECT_NEAR(volume_of(l_shape()), 0.3 * 0.51, 1e-7);
  EXPECT_NEAR(volume_of(u_shape()), 0.3 * 0.72, 1e-7);
  const double turn = 2 * std::acos(-1.0);
  EXPECT_NEAR(volume_of(arch()), 16 * 0.5 * (1 - 0.49) * std::sin(turn / 32) * 0.4, 1e-7);
  const auto ring = [&](double in, double out) { return 8 * (out * out - in * in) * std::sin(turn / 16); };
  EXPECT_NEAR(volume_of(mug()),
              0.15 * ring(0, 1) + 1.85 * ring(0.88, 1) + (2 * 0.2 * ring(1, 1.4) + 1.2 * ring(1.4, 1.6)) / 16,
              1e-6);
}

TEST(ConvexParts, WhatIsConvexHasOneHull) {
  const ConvexParts box_parts = parts_of(box({0, 0, 0}, {1, 2, 3}, 3), {1.0001, 8});
  ASSERT_EQ(box_parts.hulls.size(), 1u);
  EXPECT_EQ(box_parts.hulls[0].points.size(), 8u);
  EXPECT_NEAR(box_parts.volume, 6, 1e-6);
  EXPECT_NEAR(box_parts.excess, 1, 1e-6);
  EXPECT_EQ(parts_of(sphere_with(2000), {1.0001, 8}).hulls.size(), 1u);
  EXPECT_EQ(parts_of(thin_plate(), {1.0001, 8}).hulls.size(), 1u);
}

TEST(ConvexParts, ABentSolidWithinTheExcessHasOneHull) {
  const double of_hull = (1 - 0.7 * 0.7 / 2) / 0.51;  // 1.48
  const ConvexParts one = parts_of(l_shape());
  ASSERT_EQ(one.hulls.size(), 1u);
  EXPECT_NEAR(one.excess, of_hull, 1e-5);
  EXPECT_NEAR(one.largest_excess, of_hull, 1e-5);
  EXPECT_EQ(parts_of(l_shape(), {of_hull + 1e-3, 8}).hulls.size(), 1u);
  const ConvexParts two = parts_of(l_shape(), {of_hull - 1e-3, 8});
  EXPECT_EQ(two.hulls.size(), 2u);
  EXPECT_NEAR(two.excess, 1, 1e-5);
}

TEST(ConvexParts, ASquareFrameKeepsItsOpening) {
  for (const int n : {1, 3}) {
    const ConvexParts parts = parts_of(square_frame(0.8, 0.05, n));
    EXPECT_EQ(parts.hulls.size(), 4u);
    EXPECT_NEAR(parts.excess, 1, 1e-5);
    EXPECT_NEAR(parts.largest_excess, 1, 1e-5);
    EXPECT_NEAR(free_radius(parts, {0, 0, 0}), 0.8, 1e-6);
  }
}

TEST(ConvexParts, BarsThatShareAHullShareTheirVolume) {
  const ConvexParts parts = parts_of(square_frame(0.8, 0.05), {1.5, 3});
  ASSERT_EQ(parts.hulls.size(), 3u);
  double sum = 0, largest = 0;
  for (const CollisionHull& hull : parts.hulls) {
    sum += volume_of_hull(hull);
    largest = std::max(largest, volume_of_hull(hull));
  }
  // The two others are bars, whose hulls are they themselves.
  EXPECT_NEAR(parts.largest_excess, largest / (0.144 - (sum - largest)), 1e-4);
}

TEST(ConvexParts, AUKeepsItsOpening) {
  const ConvexParts parts = parts_of(u_shape(), {1.3, 8});
  EXPECT_EQ(parts.hulls.size(), 3u);
  EXPECT_NEAR(parts.excess, 1, 1e-5);
  EXPECT_NEAR(free_radius(parts, {0.5, 0.6, 0.15}), 0.2, 1e-6);
}

// A hull of a part that takes no more than a quarter turn stays as far from the axis as the chord between its ends.
TEST(ConvexParts, RingsAndArchesKeepTheirOpenings) {
  const ConvexParts ring = parts_of(torus(24, 12, 1, 0.1));
  EXPECT_LE(ring.hulls.size(), 8u);
  EXPECT_LE(ring.largest_excess, 1.5);
  EXPECT_GE(free_radius(ring, {0, 0, 0}), 0.9 * std::sqrt(0.5) - 0.01);
  const ConvexParts half = parts_of(arch());
  EXPECT_LE(half.hulls.size(), 8u);
  EXPECT_LE(half.largest_excess, 1.5);
  EXPECT_GE(free_radius(half, {0, 0, 0.2}), 0.7 * std::sqrt(0.5) - 0.01);
}

TEST(ConvexParts, AMugKeepsItsInsideAndItsHandle) {
  const ConvexParts parts = parts_of(mug(), {1.5, 16});
  EXPECT_LE(parts.hulls.size(), 16u);
  EXPECT_LE(parts.largest_excess, 1.5);
  EXPECT_GE(free_radius(parts, {0, 0, 1.1}), 0.7);
  const CirclePoint middle = circle_point(1, 32);  // of the handle's sector
  EXPECT_GE(free_radius(parts, {1.2 * middle.cos, 1.2 * middle.sin, 1.1}), 0.15);
}

TEST(ConvexParts, HullsAreNeverMoreThanAllowedAndTheExcessIsTheirs) {
  for (const NamedMesh& shape : bent_shapes())
    for (const double hull_excess : {1.05, 1.5})
      for (const std::uint32_t most : {1u, 2u, 3u, 4u, 5u, 8u, 20u}) {
        SCOPED_TRACE(shape.name + ", " + std::to_string(most) + " hulls");
        const ConvexParts parts = parts_of(shape.mesh, {hull_excess, most});
        EXPECT_GE(parts.hulls.size(), 1u);
        EXPECT_LE(parts.hulls.size(), most);
        double sum = 0;
        for (const CollisionHull& hull : parts.hulls) {
          sum += volume_of_hull(hull);
          EXPECT_EQ(hull.triangles.size(), 2 * hull.points.size() - 4);
          EXPECT_LE(hull.points.size(), kMaxHullPoints);
        }
        const double volume = volume_of(shape.mesh);
        EXPECT_NEAR(parts.volume, volume, 1e-5 * volume);
        EXPECT_NEAR(parts.excess, sum / volume, 1e-4);
        EXPECT_GE(parts.largest_excess, parts.excess - 1e-4);
      }
}

/// Corners may be left out if they stick out by less, and the hull's grid rounds them.
double tolerance_of(const Mesh& mesh) { return (kHullTolerance + 1e-5) * box_of(mesh).longest_side(); }

TEST(ConvexParts, TheyCoverTheSolid) {
  std::mt19937 random(7);
  for (const NamedMesh& shape : bent_shapes())
    for (const std::uint32_t most : {3u, 8u, 20u}) {
      SCOPED_TRACE(shape.name + ", " + std::to_string(most) + " hulls");
      const ConvexParts parts = parts_of(shape.mesh, {1.1, most});
      const double tolerance = tolerance_of(shape.mesh);
      for (const Vec3f& p : shape.mesh.positions) ASSERT_LE(free_radius(parts, to_double(p)), tolerance);
      const Box box = box_of(shape.mesh);
      int inside = 0;
      for (int tries = 0; tries < 1000; ++tries) {
        Vec3d p;
        for (int a = 0; a < 3; ++a)
          p[a] = box.min[a] + box.size()[a] * (static_cast<double>(random()) * 0x1p-32);
        if (winding_number(shape.mesh, p) < 0.5) continue;
        ++inside;
        ASSERT_LE(free_radius(parts, p), tolerance);
      }
      EXPECT_GT(inside, 50);
    }
}

TEST(ConvexParts, AClosedCavityCountsAsSolid) {
  const Mesh shells = nested_spheres(2, 500, 0.1);
  const ConvexParts parts = parts_of(shells);
  EXPECT_EQ(parts.hulls.size(), 1u);
  EXPECT_GT(parts.volume, 3 * volume_of(shells));  // 1 - 0.9³ = 0.27 of the ball is solid
  EXPECT_NEAR(parts.excess, 1, 0.05);
}

TEST(ConvexParts, ShellsApartHaveHullsOfTheirOwn) {
  const Mesh boxes = joined({box({0, 0, 0}, {1, 1, 1}), box({3, 0, 0}, {4, 2, 1})});
  const ConvexParts parts = parts_of(boxes);
  EXPECT_EQ(parts.hulls.size(), 2u);
  EXPECT_NEAR(parts.volume, 3, 1e-6);
  EXPECT_NEAR(parts.excess, 1, 1e-5);
}

TEST(ConvexParts, AFlatSolidHasNone) {
  const ConvexParts parts = parts_of(scaled(cube(), {1, 1, 0}));
  EXPECT_TRUE(parts.hulls.empty());
  EXPECT_EQ(parts.excess, 0);
}

TEST(ConvexParts, FarFromTheOriginTheyAreTheSame) {
  const ConvexParts parts = parts_of(translated(square_frame(0.75, 0.0625, 2), {1024, -2048, 512}));
  EXPECT_EQ(parts.hulls.size(), 4u);
  EXPECT_NEAR(parts.excess, 1, 1e-4);
}

TEST(ConvexParts, NothingOfAnEarlierCallOrAnotherThreadShows) {
  const auto same = [](const ConvexParts& a, const ConvexParts& b) {
    if (a.hulls.size() != b.hulls.size() || a.excess != b.excess || a.largest_excess != b.largest_excess)
      return false;
    for (std::size_t k = 0; k < a.hulls.size(); ++k)
      if (a.hulls[k].points != b.hulls[k].points || a.hulls[k].triangles != b.hulls[k].triangles)
        return false;
    return true;
  };
  const HullLimits limits{1.1, 8};
  const ConvexParts ring = parts_of(torus(24, 12, 1, 0.1), limits);
  (void)parts_of(mug(), limits);
  EXPECT_TRUE(same(ring, parts_of(torus(24, 12, 1, 0.1), limits)));
  ConvexParts elsewhere;
  std::thread([&] { elsewhere = parts_of(torus(24, 12, 1, 0.1), limits); }).join();
  EXPECT_TRUE(same(ring, elsewhere));
}

TEST(ConvexParts, CanBeInterruptedAtAnyPoll) {
  const Mesh ring = torus(96, 48, 1, 0.1);
  const Polled all = polled([&](const Execution& execution) { (void)parts_of(ring, {1.5, 8}, execution); });
  EXPECT_GT(all.polls, 20u);
  EXPECT_LT(all.longest_ms, kMostPollGapMs);
  for (std::uint64_t last : {std::uint64_t{1}, all.polls / 2, all.polls - 1}) {
    std::stop_source stop;
    Execution execution;
    execution.stop = stop.get_token();
    execution.watch = [&] {
      if (last-- == 0) stop.request_stop();
    };
    EXPECT_THROW((void)parts_of(ring, {1.5, 8}, execution), Interrupted);
  }
  EXPECT_EQ(parts_of(square_frame(0.8, 0.05)).hulls.size(), 4u);  // the interrupted call left nothing behind
}

}  // namespace
}  // namespace fracture::test
