// Compares the hull with its definition: it is closed, and no point of the input lies outside any face.
#include "common/physics/convex_hull.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/physics/hull_checks.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/poll_gaps.hpp"

namespace fracture::test {
namespace {

struct Family {
  std::string name;
  Points points;
};

std::vector<Family> families() {
  std::vector<Family> out;
  std::mt19937 random(7);
  const auto unit = [&random] { return static_cast<float>(random() % 100001) / 100000.0f; };
  for (const int n : {4, 5, 20, 300, 3000}) {
    Points box, ball, disc, dented;
    for (int k = 0; k < n; ++k) {
      const Vec3f p{unit(), unit(), unit()};
      const Vec3d v = to_double(p) - Vec3d{0.5, 0.5, 0.5};
      const double l = length(v) + 1e-9;
      box.push_back(p);
      ball.push_back({static_cast<float>(v.x / l), static_cast<float>(v.y / l), static_cast<float>(v.z / l)});
      disc.push_back({p.x, 0.001f * p.y, p.z});
      dented.push_back({100 + p.x, std::round(8 * p.y), std::round(8 * p.z)});
    }
    out.push_back({"box " + std::to_string(n), box});
    out.push_back({"ball " + std::to_string(n), ball});
    out.push_back({"disc " + std::to_string(n), disc});
    out.push_back({"on planes " + std::to_string(n), dented});
    ball.insert(ball.end(), ball.begin(), ball.end());
    out.push_back({"twice " + std::to_string(n), ball});
  }
  return out;
}

TEST(ConvexHull, IsClosedAndNothingLiesOutside) {
  ConvexHullBuilder builder;
  for (const Family& f : families()) {
    const auto& triangles = builder.build(f.points, 1u << 20);
    ASSERT_FALSE(triangles.empty()) << f.name;
    EXPECT_FALSE(builder.stopped_early());
    EXPECT_EQ(open_directed_edges(mesh_of(f.points, triangles)), 0u) << f.name;
    EXPECT_EQ(triangles.size(), 2 * corners(triangles).size() - 4) << f.name;  // Euler: one sphere
    EXPECT_LE(farthest_outside(f.points, triangles), 2e-5) << f.name;
  }
}

TEST(ConvexHull, EveryCornerSticksOutOfTheHullOfTheOthers) {
  ConvexHullBuilder builder;
  std::vector<Family> all = families();
  Points grid, prism;
  for (int k = 0; k < 125; ++k)
    grid.push_back({static_cast<float>(k % 5), static_cast<float>(k / 5 % 5), static_cast<float>(k / 25)});
  // Rings at four heights, with points along the sides and in the lids. The first lid is swept first.
  for (int k = 0; k < 72; ++k) {
    const double turn = 6.283185307179586 * (k / 4) / 18;
    for (const double r : {1.0, 0.5})
      prism.push_back({static_cast<float>(k % 4), static_cast<float>(r * std::cos(turn)),
                       static_cast<float>(r * std::sin(turn))});
  }
  all.push_back({"grid", grid});
  all.push_back({"prism", prism});
  int compared = 0;
  for (const Family& f : all) {
    if (f.points.size() < 5 || f.points.size() > 300 || f.name.starts_with("twice")) continue;
    const std::set<std::uint32_t> hull = corners(builder.build(f.points, 1000));
    ASSERT_GE(hull.size(), 4u) << f.name;
    for (const std::uint32_t corner : hull) {
      Points others = f.points;
      others.erase(others.begin() + corner);
      ConvexHullBuilder::Triangles triangles = builder.build(others, 1000);
      others.push_back(f.points[corner]);
      if (triangles.empty()) continue;
      EXPECT_GT(farthest_outside(others, triangles), 1e-9) << f.name << ", " << corner;
      ++compared;
    }
    // A prism whose sides and lids have additional points. Only its two outer rings are corners.
    if (f.name == "prism") {
      EXPECT_EQ(hull.size(), 36u);
    }
  }
  EXPECT_GT(compared, 300);
}

// A convex body has V >= A r / 3 and r >= w / sqrt(12) for its inscribed ball and smallest width (Steinhagen
// 1922). So a layer of tolerance x w on all of it is at most 3 sqrt(12) = 10.4 times the volume's tolerance.
TEST(ConvexHull, WithAToleranceLittleIsLeftOutHoweverThinTheBody) {
  ConvexHullBuilder builder;
  for (const Family& f : families())
    for (const double tolerance : {0.002, 0.01}) {
      SCOPED_TRACE(f.name);
      const ConvexHullBuilder::Triangles whole = builder.build(f.points, 1u << 20);
      const auto& triangles = builder.build(f.points, 1u << 20, {}, {}, tolerance);
      ASSERT_FALSE(triangles.empty());
      EXPECT_FALSE(builder.stopped_early());
      EXPECT_EQ(open_directed_edges(mesh_of(f.points, triangles)), 0u);
      EXPECT_EQ(triangles.size(), 2 * corners(triangles).size() - 4);
      EXPECT_LE(triangles.size(), whole.size());
      EXPECT_GE(volume_of(mesh_of(f.points, triangles)),
                (1 - 10.4 * tolerance) * volume_of(mesh_of(f.points, whole)));
    }
}

TEST(ConvexHull, WithAToleranceABallHasAsManyCornersAsItsBendNeeds) {
  Points ball;
  for (const Family& f : families())
    if (f.name.starts_with("ball") && f.points.size() > ball.size()) ball = f.points;
  ConvexHullBuilder builder;
  const std::size_t all = corners(builder.build(ball, 1u << 20)).size();
  ASSERT_GT(all, 300u) << "the largest family";
  // If the ball rises above a face by the tolerance, each of its corners has a third of a cap's area.
  const std::size_t few = corners(builder.build(ball, 1u << 20, {}, {}, 0.05)).size();
  EXPECT_LT(few, all / 2);
  EXPECT_GT(few, 20u);
}

TEST(ConvexHull, OfAGridIsItsEightCorners) {
  Points points;
  for (int x = 0; x <= 8; ++x)
    for (int y = 0; y <= 8; ++y)
      for (int z = 0; z <= 8; ++z)
        points.push_back({static_cast<float>(x), static_cast<float>(y), 3.0f * static_cast<float>(z)});
  ConvexHullBuilder builder;
  const auto triangles = builder.build(points, 255);
  EXPECT_EQ(triangles.size(), 12u);
  EXPECT_EQ(corners(triangles).size(), 8u);
  EXPECT_DOUBLE_EQ(volume_of(mesh_of(points, triangles)), 8 * 8 * 24);
}

TEST(ConvexHull, OfFlatPointsIsEmpty) {
  ConvexHullBuilder builder;
  Points line, plane;
  for (int k = 0; k < 50; ++k) {
    line.push_back({static_cast<float>(k), 2.0f * static_cast<float>(k), 1});
    plane.push_back(
        {static_cast<float>(k % 7), static_cast<float>(k / 7), static_cast<float>(k % 7 + k / 7)});
  }
  for (const Points& points : {Points{}, Points(3), Points(9, {1, 2, 3}), line, plane})
    EXPECT_TRUE(builder.build(points, 255).empty());
  plane.push_back({3, 3, 100});
  EXPECT_EQ(corners(builder.build(plane, 255)).count(50), 1u);
}

TEST(ConvexHull, StopsAtTheGivenNumberOfPointsWithoutLeavingASideOut) {
  ConvexHullBuilder builder;
  for (const Family& f : families()) {
    if (f.name != "ball 3000") continue;
    const auto all = builder.build(f.points, 1u << 20);
    for (const std::uint32_t most : {4u, 20u, 60u, 255u}) {
      const auto& some = builder.build(f.points, most);
      EXPECT_TRUE(builder.stopped_early());
      EXPECT_EQ(corners(some).size(), most);
      EXPECT_EQ(open_directed_edges(mesh_of(f.points, some)), 0u);
    }
    EXPECT_GT(volume_of(mesh_of(f.points, builder.build(f.points, 255))),
              0.95 * volume_of(mesh_of(f.points, all)));
  }
}

/// Points on a sphere, on two circles, on a spiral, and in a few small clumps at its ends. Either all of them
/// are extreme, or all are close together.
std::vector<Family> large_families(std::size_t n) {
  std::vector<Family> out(4);
  std::mt19937 random(3);
  const auto unit = [&random] { return static_cast<double>(random() % 1000003) / 1000003; };
  const auto add = [](Family& family, double x, double y, double z) {
    family.points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  };
  out[0].name = "sphere";
  out[1].name = "two circles";
  out[2].name = "spiral";
  out[3].name = "clumps";
  for (std::size_t k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(n), z = 2 * unit() - 1,
                 turn = 6.28 * unit();
    const double r = std::sqrt(1 - z * z);
    add(out[0], r * std::cos(turn), r * std::sin(turn), z);
    add(out[1], std::cos(12.56 * t), std::sin(12.56 * t), k % 2 == 0 ? 0 : 1);
    add(out[2], (1 - t * t) * std::cos(200 * t), (1 - t * t) * std::sin(200 * t), t);
    const double end = k % 5 == 0 ? 1 : -1;
    add(out[3], end + 1e-3 * unit() * r, 1e-3 * z + end * end * 0.1 * static_cast<double>(k % 3),
        1e-3 * unit() + 0.2 * static_cast<double>(k % 2));
  }
  return out;
}

TEST(ConvexHull, OfManyPointsGrowsWithTheirNumberAndCanBeInterruptedAnywhere) {
  std::vector<std::vector<double>> polls(4);
  for (const std::size_t n : {25'000u, 100'000u}) {
    const std::vector<Family> families = large_families(n);
    for (std::size_t f = 0; f < families.size(); ++f) {
      std::vector<std::array<std::uint32_t, 3>> triangles;
      const Polled built = polled([&](const Execution& execution) {
        triangles = ConvexHullBuilder().build(families[f].points, 255, execution);
      });
      EXPECT_LT(built.longest_ms, kMostPollGapMs) << families[f].name;
      EXPECT_FALSE(triangles.empty());
      EXPECT_EQ(open_directed_edges(mesh_of(families[f].points, triangles)), 0u) << families[f].name;
      polls[f].push_back(static_cast<double>(built.polls));
    }
  }
  for (std::size_t f = 0; f < polls.size(); ++f) {
    EXPECT_LT(std::log(polls[f][1] / polls[f][0]) / std::log(4), 1.15) << f;
    EXPECT_LT(polls[f][1] * 8192 / 100'000, 200) << "steps a point, family " << f;
  }
}

}  // namespace
}  // namespace fracture::test
