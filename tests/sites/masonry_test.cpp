// Courses along the axes of walls, rubble for parts that are not walls, and the effect of a hit on bricks.
#include "common/sites/masonry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "common/sites/pattern.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

/// Turned about y, then about z.
Vec3d turned(const Vec3d& p, double yaw, double lean) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  const Vec3d q{c * p.x + s * p.z, p.y, c * p.z - s * p.x};
  return {std::cos(lean) * q.x - std::sin(lean) * q.y, std::sin(lean) * q.x + std::cos(lean) * q.y, q.z};
}
Mesh turned(Mesh mesh, double yaw, double lean) {
  for (Vec3f& p : mesh.positions) {
    const Vec3d q = turned(to_double(p), yaw, lean);
    p = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }
  return mesh;
}

constexpr Vec3d kWall{2.4, 1.5, 0.24};
Mesh wall() { return box({0, 0, 0}, kWall, 3); }

SitePlan bricks_of(const Solid& solid, std::uint32_t pieces, BrickPattern pattern = {}) {
  SiteParameters p;
  p.sites = pieces;
  p.pattern = std::move(pattern);
  return plan_sites(solid, p, {}).value();
}

std::vector<Vec3d> places_of(const SitePlan& plan) {
  std::vector<Vec3d> places;
  for (const Vec3d& p : plan.points) places.push_back(plan.map ? plan.map.at(p).place(p) : p);
  return places;
}

/// The number of different coordinates along an axis, to a millimetre.
std::size_t levels(const std::vector<Vec3d>& places, const Vec3d& axis) {
  std::set<long> levels;
  for (const Vec3d& p : places) levels.insert(std::lround(500 * dot(p, axis)));
  std::size_t count = 0;
  long last = -10;
  for (const long level : levels) {
    count += level > last + 1;
    last = level;
  }
  return count;
}

std::set<std::uint32_t> groups_of(const SitePlan& plan) { return {plan.groups.begin(), plan.groups.end()}; }

TEST(Masonry, HasTheAxesOfAWallHoweverItStands) {
  for (const double yaw : {0.0, 0.3, 0.8, 1.4})
    for (const double lean : {0.0, 0.2, -0.5}) {
      SCOPED_TRACE(std::to_string(yaw) + ", " + std::to_string(lean));
      const Masonry masonry = masonry_of(solid_of(turned(wall(), yaw, lean)), true, 8);
      ASSERT_EQ(masonry.frames.size(), 1u);
      EXPECT_TRUE(masonry.frames[0].is_wall);
      const Matrix3& axes = masonry.frames[0].axes;
      EXPECT_NEAR(axes.determinant(), 1, 1e-9);
      EXPECT_NEAR(axes.conditioning(), 1, 1e-9);
      for (const Vec3d& along : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
        double most = 0;
        for (const Vec3d& row : axes.rows)
          most = std::fmax(most, std::fabs(dot(row, turned(along, yaw, lean))));
        EXPECT_NEAR(most, 1, 1e-5);
      }
    }
  EXPECT_EQ(masonry_of(solid_of(wall()), true, 8).frames[0].axes, Matrix3{}) << "upright ones need no map";
}

TEST(Masonry, WhatIsRoundIsNone) {
  for (const Mesh& mesh : {ico_sphere(3), torus(48, 24)}) {
    const Masonry masonry = masonry_of(solid_of(mesh), true, 8);
    ASSERT_EQ(masonry.frames.size(), 1u);
    EXPECT_FALSE(masonry.frames[0].is_wall);
    EXPECT_NEAR(masonry.frames[0].axes.determinant(), 1, 1e-12);
    EXPECT_TRUE(masonry_of(solid_of(mesh), false, 8).frames[0].is_wall) << "bricks of a given size";
    const SitePlan plan = bricks_of(solid_of(mesh), 40);
    const std::vector<std::string>& warnings = plan.remarks.warnings;
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].starts_with("The mesh is not a wall:")) << warnings[0];
    EXPECT_NE(warnings[0].find("'cell'"), std::string::npos) << "what to do";
    EXPECT_GT(levels(places_of(plan), {0, 1, 0}), 60u) << "no courses";
  }
}

TEST(Masonry, EachPartHasItsOwn) {
  const Mesh apart = translated(turned(wall(), 0.6, 0), {5, 0, 0});
  const Solid solid = solid_of(joined({wall(), apart, translated(ico_sphere(3), {-4, 0, 0}),
                                       translated(turned(wall(), 0.6 + 0.01, 0), {9, 0, 0})}));
  const Masonry masonry = masonry_of(solid, true, 8);
  ASSERT_EQ(masonry.frames.size(), 3u);
  std::set<std::uint8_t> frames(masonry.of_part.begin(), masonry.of_part.end());
  EXPECT_EQ(frames.size(), 3u);
  for (std::size_t p = 0; p < solid.parts.size(); ++p)
    EXPECT_EQ(masonry.frames[masonry.of_part[p]].is_wall, solid.parts[p].box.max.x > 0);
  const Masonry few = masonry_of(solid, true, 2);
  EXPECT_EQ(few.frames.size(), 2u);
  const SitePlan plan = bricks_of(solid, 60);
  EXPECT_TRUE(plan.remarks.warnings.empty()) << "three of four parts have courses";
  ASSERT_FALSE(plan.remarks.notes.empty());
  EXPECT_TRUE(plan.remarks.notes[0].starts_with("1 of 4 parts is not a wall (")) << plan.remarks.notes[0];
  EXPECT_EQ(plan.map.frames().size(), 3u);
  std::set<std::size_t> used;
  for (const Vec3d& p : plan.points) used.insert(plan.map.index_at(p));
  EXPECT_EQ(used.size(), 3u);
  EXPECT_NEAR(static_cast<double>(groups_of(plan).size()), 60, 3);
}

TEST(BrickPattern, BricksHaveTheirRealSizeAndPiecesAreLumpsOfThem) {
  const SitePlan plan = bricks_of(solid_of(wall()), 100);
  // 10 bricks of 240 mm have two halves each. There are 21 courses of 71 mm and two wythes of 120 mm.
  EXPECT_EQ(plan.points.size(), 20u * 21 * 2);
  EXPECT_EQ(levels(plan.points, {1, 0, 0}), 20u);
  EXPECT_EQ(levels(plan.points, {0, 1, 0}), 21u);
  EXPECT_EQ(levels(plan.points, {0, 0, 1}), 2u);
  EXPECT_EQ(groups_of(plan).size(), 100u);
  EXPECT_TRUE(plan.remarks.empty());
}

TEST(BrickPattern, CoursesTurnWithTheWall) {
  for (const double yaw : {0.4, 1.2})
    for (const double lean : {0.0, 0.3}) {
      const SitePlan plan = bricks_of(solid_of(turned(wall(), yaw, lean)), 100);
      ASSERT_EQ(plan.points.size(), 20u * 21 * 2);
      const std::vector<Vec3d> places = places_of(plan);
      EXPECT_EQ(levels(places, turned({1, 0, 0}, yaw, lean)), 20u);
      EXPECT_EQ(levels(places, turned({0, 1, 0}, yaw, lean)), 21u);
      EXPECT_EQ(levels(places, turned({0, 0, 1}, yaw, lean)), 2u);
    }
}

TEST(BrickPattern, BricksAreInProportionWhereThereAreTooFewOrTooManyRealOnes) {
  for (const double scale : {0.01, 0.1, 10.0, 100.0}) {
    SCOPED_TRACE(scale);
    const SitePlan plan = bricks_of(solid_of(box({0, 0, 0}, scale * kWall, 3)), 60);
    std::vector<Vec3d> in_proportion;
    for (const Vec3d& p : plan.points) in_proportion.push_back((1 / scale) * p);
    EXPECT_GE(levels(in_proportion, {0, 1, 0}), 8u);
    EXPECT_EQ(groups_of(plan).size(), 60u);
    EXPECT_GE(plan.points.size(), 60u);
    EXPECT_LE(plan.points.size(), 2u * 60 * 8);
    EXPECT_TRUE(plan.remarks.warnings.empty());
    ASSERT_EQ(plan.remarks.notes.size(), 1u);
    EXPECT_NE(plan.remarks.notes[0].find("% of the size of real ones"), std::string::npos);
  }
}

TEST(BrickPattern, OnlyBricksThatTheSolidMeetsAreLaid) {
  // Two walls at a right angle fill a tenth of their box.
  const Solid corner =
      solid_of(joined({wall(), translated(box({0, 0, 0}, {0.24, 1.5, 2.4}, 3), {-0.5, 0, 0.5})}));
  ASSERT_EQ(masonry_of(corner, true, 8).frames.size(), 1u);
  const SitePlan plan = bricks_of(corner, 150);
  EXPECT_LE(plan.points.size(), 2u * 2 * 20 * 21 * 2);
  for (const Vec3d& p : plan.points) {
    const auto beyond = [](double x, double low, double high) {
      return std::fmax(0, std::fmax(low - x, x - high));
    };
    const double first = beyond(p.x, 0, 2.4) + beyond(p.z, 0, 0.24),
                 second = beyond(p.x, -0.5, -0.26) + beyond(p.z, 0.5, 2.9);
    EXPECT_LT(std::fmin(first, second), 0.2);
  }
}

TEST(BrickPattern, BricksAtTheHitAreCrushedAndHalvedAndLumpsGrowFartherAway) {
  const Vec3d hit{1.2, 0.75, 0.24};
  const SitePlan plan = bricks_of(solid_of(wall()), 100, {.impacts = {hit}});
  EXPECT_EQ(groups_of(plan).size(), 100u);
  std::map<std::uint32_t, std::vector<Vec3d>> pieces;
  for (std::size_t k = 0; k < plan.points.size(); ++k) pieces[plan.groups[k]].push_back(plan.points[k]);
  double near = 0, far = 0;
  std::size_t of_near = 0, of_far = 0, off_lattice = 0, halves = 0;
  for (const auto& [group, sites] : pieces) {
    Vec3d mean;
    for (const Vec3d& p : sites) mean = mean + (1.0 / static_cast<double>(sites.size())) * p;
    const double distance = length(mean - hit);
    (distance < 0.35 ? near : far) += static_cast<double>(sites.size());
    ++(distance < 0.35 ? of_near : of_far);
    const double course = (mean.y / (1.5 / 21)) - 0.5;
    const bool crumb = sites.size() == 1 && std::fabs(course - std::nearbyint(course)) > 1e-3;
    off_lattice += crumb;
    halves += sites.size() == 1 && !crumb;
    if (crumb) {
      EXPECT_LT(distance, 0.4);
    }
  }
  EXPECT_GE(off_lattice, 15u) << "five bricks in quarters";
  EXPECT_GE(halves, 15u) << "ten bricks in halves";
  ASSERT_GT(of_near, 0u);
  ASSERT_GT(of_far, 0u);
  EXPECT_GT(far / static_cast<double>(of_far), 4 * near / static_cast<double>(of_near));
}

}  // namespace
}  // namespace fracture::test
