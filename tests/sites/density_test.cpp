// Sites where the surface is painted.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "common/mesh/material_library.hpp"
#include "common/sites/density.hpp"
#include "common/sites/pattern.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

/// A bar of 4 m that is white to x = 1 and black beyond. The white part also has the material "weak".
Mesh painted_bar() {
  Mesh bar = box({0, 0, 0}, {4, 1, 1}, 16);
  bar.attributes.colors.emplace_back();
  for (const Vec3f& p : bar.positions) {
    const float light = p.x <= 1 ? 1.0f : 0.0f;
    bar.attributes.colors[0].push_back({light, light, light, 1});
  }
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"name", "strong"}}, {{"name", "weak"}}};
  bar.library = library;
  bar.material.clear();
  for (const auto& t : bar.triangles)
    bar.material.push_back(std::all_of(t.begin(), t.end(), [&](auto w) { return bar.positions[w].x <= 1; }));
  return bar;
}

SiteParameters painted(std::string from, SitePattern pattern = {}, std::uint32_t sites = 200) {
  SiteParameters p;
  p.sites = sites;
  p.pattern = std::move(pattern);
  p.density_from = std::move(from);
  return p;
}

double share_below(const std::vector<Vec3d>& points, double x) {
  const auto below = std::count_if(points.begin(), points.end(), [&](const Vec3d& p) { return p.x < x; });
  return static_cast<double>(below) / static_cast<double>(points.size());
}

TEST(Density, MostSitesAreAtThePaintedEndOfABar) {
  const Solid bar = solid_of(painted_bar());
  for (const std::string from : {"COLOR_0", "weak", "1"}) {
    const SitePlan plan = plan_sites(bar, painted(from), {}).value();
    ASSERT_EQ(plan.points.size(), 200u) << from;
    // A quarter of the volume has 32 times the density: 32 of 35 sites, plus those in the zone where colours
    // fade.
    EXPECT_GT(share_below(plan.points, 1.25), 0.85) << from;
    EXPECT_LT(share_below(plan.points, 1.25), 1) << "what is not painted breaks, too";
    EXPECT_EQ(plan_sites(bar, painted(from), {})->points, plan.points);
  }
  EXPECT_NEAR(share_below(plan_sites(bar, painted(""), {})->points, 1), 0.25, 0.1);
  EXPECT_GT(share_below(plan_sites(bar, painted("strong"), {})->points, 4) -
                share_below(plan_sites(bar, painted("strong"), {})->points, 1),
            0.9);
}

TEST(Density, WeightsWhatPatternsScatterEvenlyAndLeavesImpactsAlone) {
  const Solid bar = solid_of(painted_bar());
  EXPECT_GT(
      share_below(plan_sites(bar, painted("COLOR_0", ClusteredPattern{.clusters = 20}), {})->points, 1.4),
      0.8);
  const ImpactPattern far{.impacts = {{3.9, 0.5, 0.5}}, .radius = 0.2, .share = 0.5};
  const std::vector<Vec3d> points = plan_sites(bar, painted("COLOR_0", far), {})->points;
  EXPECT_NEAR(share_below(points, 1.25), 0.47, 0.06);
  EXPECT_NEAR(1 - share_below(points, 3.69), 0.5, 0.02);
}

TEST(Density, PaintedAllTheSameIsAsWithout) {
  Mesh mesh = painted_bar();
  for (const float light : {1.0f, 0.2f}) {
    for (Vec4f& c : mesh.attributes.colors[0]) c = {light, light, light, 1};
    const Solid bar = solid_of(mesh);
    EXPECT_EQ(plan_sites(bar, painted("COLOR_0"), {})->points, plan_sites(bar, painted(""), {})->points);
  }
}

TEST(Density, FollowsThePaintThroughTheMapOfCells) {
  const Solid bar = solid_of(painted_bar());
  SiteParameters p = painted("COLOR_0");
  p.anisotropy = {.stretch = 4, .grain = Vec3d{1, 2, 0}};
  const SitePlan plan = plan_sites(bar, p, {}).value();
  std::vector<Vec3d> places;
  for (const Vec3d& site : plan.points) places.push_back(plan.map.at(site).place(site));
  EXPECT_GT(share_below(places, 1.25), 0.85);
}

TEST(Density, WhatIsNotThereIsSaidByName) {
  const Solid bar = solid_of(painted_bar());
  Mesh black = painted_bar();
  for (Vec4f& c : black.attributes.colors[0]) c = {0, 0, 0, 1};
  const Solid unlit = solid_of(black);
  const auto expect_refused = [](const Solid& solid, const std::string& from) {
    const Expected<SitePlan> plan = plan_sites(solid, painted(from), {});
    ASSERT_FALSE(plan) << from;
    EXPECT_EQ(plan.error().code, ErrorCode::kBadParameter);
    EXPECT_EQ(plan.error().pointer, "density_from");
    EXPECT_NE(plan.error().detail.find(from), std::string::npos) << plan.error().detail;
  };
  for (const char* from : {"COLOR_1", "COLOR_9", "weakest", "2"}) expect_refused(bar, from);
  expect_refused(unlit, "COLOR_0");
  expect_refused(solid_of(cube()), "COLOR_0");
}

}  // namespace
}  // namespace fracture::test
