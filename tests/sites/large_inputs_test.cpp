// Sites for large meshes, and very large numbers of sites.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "common/sites/column_sampler.hpp"
#include "common/sites/pattern.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

const Execution kAlone{};  // outlives the samplers

/// A cylinder whose lids are fans. Their triangles are as long as the cylinder is wide, thin, and point in
/// all directions.
Mesh cylinder(int segments) {
  std::vector<Vec2d> outline;
  for (int k = 0; k < segments; ++k) {
    const CirclePoint p = circle_point(k, segments);
    outline.push_back({p.cos, p.sin});
  }
  return prism_over(outline);
}

TEST(LargeInputs, EveryPatternCanBeInterruptedAnywhere) {
  const Solid sphere = solid_of(sphere_with(300'000));
  for (const SitePattern& pattern :
       {SitePattern{UniformPattern{}}, SitePattern{ImpactPattern{}}, SitePattern{ClusteredPattern{}},
        SitePattern{GridPattern{}}, SitePattern{BrickPattern{}}, SitePattern{SlicePattern{}},
        SitePattern{RadialPattern{}}}) {
    SiteParameters parameters;
    parameters.pattern = pattern;
    parameters.sites = pattern.index() == 5 ? 10'000 : 40'000;
    Expected<SitePlan> plan;
    const Polled made =
        polled([&](const Execution& execution) { plan = plan_sites(sphere, parameters, execution); });
    EXPECT_LT(made.longest_ms, kMostPollGapMs) << kPatternTraits[pattern.index()].name;
    ASSERT_TRUE(plan) << kPatternTraits[pattern.index()].name << ": " << plan.error().detail;
    EXPECT_GT(plan->points.size(), 1000u);
  }
}

// The box of a thin triangle across a lid contains a twelfth of all columns.
TEST(LargeInputs, ThinTrianglesAreNotComparedWithEveryColumnInTheirBoxes) {
  std::vector<double> comparisons;
  for (const int size : {1000, 4000}) {
    const Solid solid = solid_of(cylinder(size));
    sites_detail::ColumnSampler sampler(solid, 1, kAlone);
    EXPECT_EQ(sampler.sample(static_cast<std::uint32_t>(size)).size(), static_cast<std::size_t>(size));
    comparisons.push_back(static_cast<double>(sampler.comparisons()));
  }
  // Columns are compared along each triangle, not across its box. With four times as many triangles and
  // columns, that is eight times the work and not sixteen.
  EXPECT_LT(comparisons[0], 100 * 1000);
  EXPECT_LT(std::log(comparisons[1] / comparisons[0]) / std::log(4), 1.55);
}

TEST(LargeInputs, ThinTrianglesHaveTheirShareOfThePoints) {
  // The number of comparisons affects only the cost: the sequence is the same, however coarse the grid of a
  // batch is.
  const Solid solid = solid_of(cylinder(700));
  sites_detail::ColumnSampler all(solid, 3, kAlone), few(solid, 3, kAlone);
  const std::vector<Vec3d> many = all.sample(5000);
  for (const std::uint32_t count : {1u, 7u, 60u}) {
    const std::vector<Vec3d> some = few.sample(count);
    for (std::uint32_t k = 0; k < count; ++k) EXPECT_EQ(some[k], many[k]);
  }
  int inner = 0;
  for (const Vec3d& p : many) {
    EXPECT_LE(p.x * p.x + p.y * p.y, 1 + 1e-6);
    inner += p.x * p.x + p.y * p.y < 0.5;
  }
  EXPECT_NEAR(inner, 2500, 6 * std::sqrt(1250.0));
  for (std::size_t k = 0; k < many.size(); k += 50) {
    const Vec3d out{1.3 * many[k].x + 0.8, many[k].y, many[k].z};
    const std::vector<Vec3d> both{many[k], out};
    const std::vector<bool> inside = few.inside(both);
    EXPECT_TRUE(inside[0]);
    EXPECT_EQ(inside[1], out.x * out.x + out.y * out.y < 1 - 1e-4);
  }
}

TEST(LargeInputs, SpreadPointsAreEvenInThinWallsAndCostLittle) {
  // A hollow cube and one that is twice as large.
  const Mesh small = joined({cube(), reversed(scaled(cube(), {0.96, 0.96, 0.96}))});
  const Solid solid = solid_of(joined({small, translated(scaled(small, {2, 2, 2}), {3, 0, 0})}));
  sites_detail::ColumnSampler spread(solid, 0, kAlone), sampled(solid, 0, kAlone);
  const std::vector<Vec3d> points = spread.spread(900);
  ASSERT_NEAR(static_cast<double>(points.size()), 900, 1);
  int in_small = 0;
  for (const Vec3d& p : points) in_small += p.x < 1;
  EXPECT_NEAR(in_small, 100, 30);  // 1 to 8 by volume
  const std::vector<bool> inside = sites_detail::ColumnSampler(solid, 0, kAlone).inside(points);
  EXPECT_EQ(std::count(inside.begin(), inside.end(), false), 0);
  // All chords have one length. Points lie at both ends and in between.
  const Solid whole = solid_of(cube());
  const std::vector<Vec3d> in_cube = sites_detail::ColumnSampler(whole, 0, kAlone).spread(800);
  std::array<int, 8> octants{};
  for (const Vec3d& p : in_cube)
    ++octants[static_cast<std::size_t>((p.x > 0) + 2 * (p.y > 0) + 4 * (p.z > 0))];
  for (const int n : octants) EXPECT_NEAR(n, 100, 50);
  EXPECT_EQ(sampled.sample(900).size(), 900u);
  EXPECT_LT(4 * spread.comparisons(), sampled.comparisons());
}

// A thousand nested boxes. Columns cross all of them. As many columns as a plain surface allows would hold
// hundreds of times as many crossings.
TEST(LargeInputs, ManyLayersAreLookedThroughInSmallBatches) {
  std::vector<Mesh> boxes;
  for (int k = 0; k < 1000; ++k) {
    const double s = 1 + 1e-3 * k;
    boxes.push_back(box({-s, -s, -s}, {s, s, s}));
  }
  const Solid solid = solid_of(joined(boxes));
  std::vector<Vec3d> points;
  for (int k = 0; k < 3000; ++k)
    points.push_back({0.0005 * k - 0.9, 0.7 - 0.0004 * k, k % 2 == 0 ? 0.5 : 1.9995});
  const Polled sampled = polled([&](const Execution& execution) {
    sites_detail::ColumnSampler sampler(solid, 1, execution);
    const std::vector<bool> inside = sampler.inside(points);
    EXPECT_EQ(std::count(inside.begin(), inside.end(), true), 1500);
    EXPECT_EQ(sampler.sample(3).size(), 3u);
  });
  EXPECT_LT(sampled.longest_ms, kMostPollGapMs);
}

}  // namespace
}  // namespace fracture::test
