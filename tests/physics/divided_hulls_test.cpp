// Hulls of fragments whose own hull would close an opening, against figures by hand.
#include "common/physics/divided_hulls.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/physics/bent_shapes.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

constexpr double kInside = 0.8, kThick = 0.1;  // of the frame around [-kInside, kInside]² in [-1, 1]²

Mesh frame() {
  return grid_solid(
      {{{-1, -kInside, kInside, 1}, {-1, -kInside, kInside, 1}, {-kThick, kThick}}},
      [](int i, int j, int) { return i != 1 || j != 1; }, 2);
}
const double kFrameVolume = 2 * kThick * 4 * (1 - kInside * kInside);

Fractured cut(const Mesh& mesh, PointsPattern sites, FractureParameters p = {}) {
  p.pattern = std::move(sites);
  p.hulls = Hulls::kConvex;
  return fracture_mesh(mesh, p);
}

Box box_of_hull(const Fractured& made, std::size_t fragment, const CollisionHull& hull) {
  Box box;
  for (const Vec3f& p : hull.points) box.add(to_double(p) + made.set.fragments[fragment].pivot);
  return box;
}

/// Each hull leaves the opening free: it is on one side of one of its four edges.
void expect_opening(const Fractured& made) {
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k)
    for (const CollisionHull& hull : made.hulls.of(k)) {
      const Box box = box_of_hull(made, k, hull);
      EXPECT_GT(std::max({box.min.x, -box.max.x, box.min.y, -box.max.y}), kInside - 1e-6) << "fragment " << k;
    }
}

double volume_of_hulls(const Fractured& made, std::size_t fragment) {
  double sum = 0;
  for (const CollisionHull& hull : made.hulls.of(fragment)) sum += volume_within(hull.points, hull.triangles);
  return sum;
}

TEST(DividedHulls, AFrameThatStaysWholeHasABarForEachSide) {
  const Fractured made = cut(frame(), {{{0, 0, 0}}});
  ASSERT_EQ(made.hulls.of(0).size(), 4u);
  expect_opening(made);
  EXPECT_NEAR(made.report.hulls->excess, 1, 1e-5);
  EXPECT_NEAR(volume_of_hulls(made, 0), kFrameVolume, 0.03 * kFrameVolume) << "less what the inset takes";
}

TEST(DividedHulls, TheLimitsDecide) {
  const double of_one = 1 / (1 - kInside * kInside);  // 2.78
  FractureParameters p;
  p.hull_limits.excess = of_one + 1e-3;
  const Fractured loose = cut(frame(), {{{0, 0, 0}}}, p);
  EXPECT_EQ(loose.hulls.of(0).size(), 1u);
  EXPECT_NEAR(loose.report.hulls->excess, of_one, 1e-4);
  p.hull_limits.excess = of_one - 1e-3;
  EXPECT_EQ(cut(frame(), {{{0, 0, 0}}}, p).hulls.of(0).size(), 4u);
  p.hull_limits.count = 1;
  EXPECT_EQ(cut(frame(), {{{0, 0, 0}}}, p).hulls.of(0).size(), 1u);
  p.hull_limits.count = 3;
  const Fractured three = cut(frame(), {{{0, 0, 0}}}, p);
  EXPECT_EQ(three.hulls.of(0).size(), 3u);
  EXPECT_GT(three.report.hulls->excess, 1.1);
}

// A bent square whose two sides coincide after rounding. Its volume before rounding may be anything.
TEST(DividedHulls, OfASheetWithoutVolumeHaveAFiniteExcess) {
  FragmentSet set;
  Fragment& f = set.fragments.emplace_back();
  f.positions = {{0, 0, 0}, {1, 0, 0.25f}, {1, 1, 0}, {0, 1, 0.25f}};
  f.topology = {0, 1, 2, 3};
  f.indices = {0, 1, 2, 0, 2, 3, 2, 1, 0, 3, 2, 0};
  f.sites = {SiteId{0}};
  f.mass.area = 2;
  const auto hulls = [&](double volume) {
    f.mass.volume = volume;
    return make_collision_hulls(set, {}, {.excess = 1.5, .count = 4}, {});
  };
  const double tetrahedron = 0.25 / 3;  // 1 · 1 · 0.25, less four corners of a sixth each
  EXPECT_EQ(hulls(1e-9).of(0).size(), 1u);
  EXPECT_NEAR(hulls(1e-9).report().excess, tetrahedron / 1e-9, 1e-3 / 1e-9);
  EXPECT_EQ(hulls(0).of(0).size(), 1u);
  EXPECT_EQ(hulls(0).report().excess, 0);
}

TEST(DividedHulls, OfHalvesStayInTheirCells) {
  const Fractured made = cut(frame(), {{{-0.5, 0, 0}, {0.5, 0, 0}}});
  ASSERT_EQ(made.set.fragments.size(), 2u);
  expect_opening(made);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(made.hulls.of(k).size(), 3u);
    const double side = made.set.fragments[k].mass.center_of_mass.x;
    for (const CollisionHull& hull : made.hulls.of(k)) {
      const Box box = box_of_hull(made, k, hull);
      EXPECT_GT(side > 0 ? box.min.x : -box.max.x, 0);
    }
  }
}

TEST(DividedHulls, OfRoughHalvesStayInTheirCellsToo) {
  FractureParameters p;
  p.roughness.amplitude = 0.04;
  const Fractured made = cut(frame(), {{{-0.5, 0, 0}, {0.5, 0, 0}}}, p);
  ASSERT_EQ(made.set.fragments.size(), 2u);
  expect_opening(made);
  double beyond = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    const Fragment& f = made.set.fragments[k];
    EXPECT_EQ(made.hulls.of(k).size(), 3u);
    for (const CollisionHull& hull : made.hulls.of(k)) {
      const Box box = box_of_hull(made, k, hull);
      EXPECT_GT(f.mass.center_of_mass.x > 0 ? box.min.x : -box.max.x, 0);
      Mesh surface;
      surface.positions = hull.points;
      surface.triangles = hull.triangles;
      EXPECT_EQ(open_directed_edges(surface), 0u);
    }
    for (const Vec3f& q : f.positions)
      beyond = std::max(beyond, -(q.x + f.pivot.x) * f.mass.center_of_mass.x);
    EXPECT_GT(volume_of_hulls(made, k), 0.9 * f.mass.volume);
  }
  EXPECT_GT(beyond, 1e-3) << "the cuts are rough";
}

// Each half consists of two cells. The hull of a quarter has 0.68 / 0.36 of its volume, and comes as near as 0.57 to the middle.
TEST(DividedHulls, OfHalvesOfSeveralCellsKeepTheOpening) {
  for (const double rough : {0.0, 0.04}) {
    FractureParameters p;
    p.roughness.amplitude = rough;
    const Fractured made =
        cut(frame(), {{{-0.5, -0.5, 0}, {-0.5, 0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}}, {0, 0, 1, 1}}, p);
    ASSERT_EQ(made.set.fragments.size(), 2u);
    expect_opening(made);
    for (std::size_t k = 0; k < 2; ++k) {
      const Fragment& f = made.set.fragments[k];
      EXPECT_EQ(f.bodies.size(), 2u);
      EXPECT_EQ(made.hulls.of(k).size(), 3u) << "a bar for each side";
      for (const CollisionHull& hull : made.hulls.of(k)) {
        const Box box = box_of_hull(made, k, hull);
        EXPECT_GT(f.mass.center_of_mass.x > 0 ? box.min.x : -box.max.x, 0);
      }
      EXPECT_GT(volume_of_hulls(made, k), 0.9 * f.mass.volume);
    }
    EXPECT_LT(made.report.hulls->excess, 1.1);
  }
}

// Three quarters of a frame are four bars, two of them half as long as the others.
TEST(DividedHulls, OfThreeQuartersOfAFrameKeepTheOpening) {
  const Fractured made =
      cut(frame(), {{{-0.5, -0.5, 0}, {-0.5, 0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}}, {0, 0, 0, 1}});
  ASSERT_EQ(made.set.fragments.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_EQ(made.hulls.of(k).size(), made.set.fragments[k].bodies.size() == 3 ? 4u : 2u);
  expect_opening(made);
}

TEST(DividedHulls, AWholeFrameOfManyCellsKeepsItsOpening) {
  PointsPattern sites{random_sites(box_of(frame()), 12, 3), std::vector<std::uint32_t>(12, 0)};
  const Fractured made = cut(frame(), std::move(sites));
  ASSERT_EQ(made.set.fragments.size(), 1u);
  EXPECT_GT(made.set.fragments[0].bodies.size(), 4u);
  EXPECT_LE(made.hulls.of(0).size(), 4u);
  expect_opening(made);
}

// Each shard is curved, but its outline is convex.
TEST(DividedHulls, ShardsOfAHollowSphereKeepOneHull) {
  const Mesh sphere = nested_spheres(2, 2000, 0.05);
  std::vector<Vec3d> sites = random_sites(box_of(sphere), 30, 5);
  for (Vec3d& site : sites) site = (1 / length(site)) * site;
  const Fractured made = cut(sphere, {sites});
  EXPECT_GT(made.report.hulls->excess, 2);
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) EXPECT_EQ(made.hulls.of(k).size(), 1u);
}

TEST(DividedHulls, AClosedCavityIsNoOpening) {
  const Fractured made = cut(nested_spheres(2, 500, 0.1), {{{0, 0, 0}}});
  EXPECT_EQ(made.hulls.of(0).size(), 1u);
  EXPECT_NEAR(made.report.hulls->excess, 1, 0.05);
}

TEST(DividedHulls, WhatIsConvexHasNoExcess) {
  const Fractured made = cut(box({0, 0, 0}, {1, 1, 1}), {random_sites(box_of(cube()), 20, 5)});
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) EXPECT_EQ(made.hulls.of(k).size(), 1u);
  EXPECT_NEAR(made.report.hulls->excess, 1, 1e-3);
}

// A fragment that was merged from several cells had a hull for each.
TEST(DividedHulls, MergedCellsShareTheHullsThatAreAllowed) {
  PointsPattern sites{random_sites(box_of(cube()), 30, 9)};
  for (std::uint32_t k = 0; k < 30; ++k) sites.groups.push_back(k < 10 ? 0 : k);
  const Fractured made = cut(cube(), sites);
  std::size_t most = 0;
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
    most = std::max(most, made.hulls.of(k).size());
    if (made.set.fragments[k].sites.size() == 1) continue;
    // A hull is behind the bisectors of one of the fragment's sites with every other site.
    for (const CollisionHull& hull : made.hulls.of(k))
      for (const Vec3f& q : hull.points) {
        const Vec3d p = to_double(q) + made.set.fragments[k].pivot;
        std::size_t nearest = 0;
        for (std::size_t s = 0; s < 30; ++s)
          if (length(p - sites.points[s]) < length(p - sites.points[nearest])) nearest = s;
        EXPECT_LT(nearest, 10u);
      }
  }
  EXPECT_EQ(most, 4u);
}

}  // namespace
}  // namespace fracture::test
