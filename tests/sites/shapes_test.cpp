#include "common/sites/shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "common/bvh/box_tree.hpp"
#include "common/sites/generators.hpp"
#include "common/sites/pattern.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

constexpr std::size_t kMost = CellMap::kMostFrames;

/// A top along x and z, four legs along y, and a ball on the top.
constexpr std::size_t kTop = 0, kFirstLeg = 1, kBall = 5, kParts = 6;
Mesh laid_table() {
  std::vector<Mesh> parts{box({0, 1, 0}, {3, 1.1, 1}, 2)};
  for (const double x : {0.1, 2.8})
    for (const double z : {0.1, 0.8}) parts.push_back(box({x, 0, z}, {x + 0.1, 0.99, z + 0.1}, 2));
  Mesh ball = ico_sphere(3);
  for (Vec3f& p : ball.positions) p = {0.2f * p.x + 1.5f, 0.2f * p.y + 1.4f, 0.2f * p.z + 0.5f};
  parts.push_back(ball);
  return joined(parts);
}

Mesh tilted(Mesh mesh, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  for (Vec3f& p : mesh.positions)
    p = {static_cast<float>(c * p.x - s * p.y), static_cast<float>(s * p.x + c * p.y), p.z};
  return mesh;
}

SiteParameters by_shape(std::uint32_t sites, std::vector<Vec3d> impacts = {}) {
  SiteParameters p;
  p.sites = sites;
  p.pattern = RadialPattern{.around = RadialPattern::Around::kShape, .impacts = std::move(impacts)};
  return p;
}

Shapes shapes_for(const Solid& solid, const SiteParameters& request) {
  return sites_detail::shapes_for(solid, std::get<RadialPattern>(request.pattern), {}).shapes;
}

/// The sites in the frame of the answer, by the number of their frame.
std::map<std::size_t, std::vector<Vec3d>> sites_by_frame(const SitePlan& plan) {
  std::map<std::size_t, std::vector<Vec3d>> sites;
  for (const Vec3d& site : plan.points)
    sites[plan.map.index_at(site)].push_back(plan.map.at(site).place(site));
  return sites;
}

TEST(Shapes, APlateARodAndABodyAreToldApartHoweverTheyStand) {
  for (const double angle : {0.0, 0.4, 1.1}) {
    SCOPED_TRACE(angle);
    const Solid solid = solid_of(tilted(laid_table(), angle));
    ASSERT_EQ(solid.parts.size(), kParts);
    const Shapes shapes = shapes_of(solid, kMost);
    ASSERT_EQ(shapes.of_part.size(), kParts);
    const Vec3d up{-std::sin(angle), std::cos(angle), 0};
    for (std::size_t p = 0; p < kParts; ++p) {
      SCOPED_TRACE(p);
      const PartShape& shape = shapes.of_part[p];
      EXPECT_EQ(shape.thin.has_value(), p == kTop);
      EXPECT_EQ(shape.rod.has_value(), p != kTop && p != kBall);
      EXPECT_LT(length(shape.middle - solid.parts[p].box.center()), 1e-5);
      if (shape.thin) {
        EXPECT_NEAR(std::fabs(dot(*shape.thin, up)), 1, 1e-6);
      }
      if (!shape.rod) continue;
      EXPECT_NEAR(std::fabs(dot(shape.rod->axis, up)), 1, 1e-6);
      EXPECT_NEAR(shape.rod->to - shape.rod->from, 0.99, 1e-5);
      EXPECT_NEAR(shape.rod->to + shape.rod->from, 0, 1e-5);
      EXPECT_NEAR(shape.rod->width, 0.1, 1e-5);
    }
  }
}

TEST(Shapes, WhatIsOneBreaksAsOne) {
  EXPECT_EQ(shapes_of(solid_of(cube(2)), kMost).frames, 0u);
  const Mesh panes =
      joined({box({0, 0, 0}, {1, 1, 0.01}), box({1.1, 0, 0}, {2, 1, 0.01}), box({2.1, 0, 0}, {3, 1, 0.01})});
  EXPECT_EQ(shapes_of(solid_of(panes), kMost).frames, 0u) << "panes of one window";
  EXPECT_FALSE(map_of_cells(solid_of(panes), by_shape(40), {}).value());
}

TEST(Shapes, BottlesOnATableAreNoPlate) {
  std::vector<Mesh> bottles;
  for (int k = 0; k < 9; ++k)
    bottles.push_back(
        box({1.0 * (k % 3), 0, 1.0 * (k / 3)}, {1.0 * (k % 3) + 0.1, 0.3, 1.0 * (k / 3) + 0.1}));
  const Solid solid = solid_of(joined(bottles));
  EXPECT_TRUE(thin_axis(solid)) << "all of them together";
  EXPECT_EQ(shapes_of(solid, kMost).frames, kMost);
}

TEST(Shapes, TheLargestPartsHaveAFrameEachTheOthersShareOne) {
  std::vector<Mesh> bars;
  for (int k = 0; k < 12; ++k)  // the last one is the largest
    bars.push_back(box({0, 2.0 * (k % 4), 1.0 * k}, {2 + 0.1 * k, 2.0 * (k % 4) + 0.2, 1.0 * k + 0.2}));
  const Shapes shapes = shapes_of(solid_of(joined(bars)), kMost);
  ASSERT_EQ(shapes.frames, kMost);
  for (std::size_t p = 0; p < 12; ++p)
    EXPECT_EQ(shapes.frame_of_part[p], std::min<std::size_t>(11 - p, kMost - 1)) << p;
}

TEST(RadialByParts, EachPartHasItsShareByVolumeAndARodIsCutAlongItself) {
  const Solid solid = solid_of(laid_table());
  const SitePlan plan = plan_sites(solid, by_shape(400), {}).value();
  const Shapes shapes = shapes_of(solid, kMost);
  const auto sites = sites_by_frame(plan);
  ASSERT_EQ(sites.size(), kParts);
  double volume = 0;
  for (const Part& part : solid.parts) volume += part.volume;
  for (std::size_t p = kFirstLeg; p < kBall; ++p) {
    SCOPED_TRACE(p);
    const std::vector<Vec3d>& of_leg = sites.at(shapes.frame_of_part[p]);
    EXPECT_EQ(of_leg.size(), std::nearbyint(400 * 0.0099 / volume));
    std::vector<double> heights;
    for (const Vec3d& site : of_leg) {
      heights.push_back(site.y);
      // Within a fifth of its width of the axis.
      EXPECT_LT(std::fabs(site.x - shapes.of_part[p].middle.x), 0.02);
      EXPECT_LT(std::fabs(site.z - shapes.of_part[p].middle.z), 0.02);
    }
    std::sort(heights.begin(), heights.end());
    const double even = 0.99 / static_cast<double>(heights.size());
    for (std::size_t k = 0; k < heights.size(); ++k) {
      EXPECT_GE(heights[k], static_cast<double>(k) * even);
      EXPECT_LE(heights[k], static_cast<double>(k + 1) * even);
    }
  }
  // Rings and spokes around an axis lie in a plane. Those around a point do not.
  const auto thickness = [&](std::size_t p) {
    Box box;
    for (const Vec3d& site : sites.at(shapes.frame_of_part[p])) box.add(site);
    return box.size().y;
  };
  EXPECT_LT(thickness(kTop), 1e-4);
  EXPECT_GT(thickness(kBall), 0.2);
}

TEST(RadialByParts, ARodOfMorePiecesThanLengthsIsNotSliced) {
  // A ball and a bar that is five times as long as wide. The bar gets about 6 pieces, then 60.
  Mesh ball = ico_sphere(3);
  for (Vec3f& p : ball.positions) p.z += 3;
  const Solid solid = solid_of(joined({ball, box({0, 0, 0}, {5, 1, 1}, 2)}));
  const Shapes shapes = shapes_of(solid, kMost);
  const std::size_t bar = solid.parts[0].box.size().x > 3 ? 0 : 1;
  ASSERT_TRUE(shapes.of_part[bar].rod);
  const auto spread = [&](std::uint32_t sites) {
    const auto made = sites_by_frame(plan_sites(solid, by_shape(sites), {}).value());
    Box box;
    for (const Vec3d& site : made.at(shapes.frame_of_part[bar])) box.add(site);
    return std::fmax(box.size().y, box.size().z);
  };
  EXPECT_LT(spread(11), 0.4) << "along the axis";
  EXPECT_GT(spread(110), 1.0) << "around a point";
}

TEST(RadialByParts, PiecesOfARodGatherAtTheHit) {
  const Solid solid = solid_of(laid_table());
  // The leg that is hit gets about 15 of 20 pieces.
  const SiteParameters request = by_shape(20, {{0.15, 0, 0.15}});
  const auto sites = sites_by_frame(plan_sites(solid, request, {}).value());
  const Shapes shapes = shapes_for(solid, request);
  const auto mean_height = [&](std::size_t p) {
    double sum = 0;
    for (const Vec3d& site : sites.at(shapes.frame_of_part[p])) sum += site.y;
    return sum / static_cast<double>(sites.at(shapes.frame_of_part[p]).size());
  };
  // The mean of u^1.7 is 1 / 2.7.
  EXPECT_NEAR(mean_height(kFirstLeg), 0.99 / 2.7, 0.06);
  EXPECT_GT(sites.at(shapes.frame_of_part[kFirstLeg]).size(), 10u);
}

TEST(RadialByParts, WhatIsSmallIsWholeAndTinyThingsInOneFrameMakeNoSites) {
  std::vector<Mesh> parts{cube(2)};
  for (int k = 0; k < 100; ++k) parts.push_back(box({3 + 0.1 * k, 0, 0}, {3.05 + 0.1 * k, 0.05, 0.05}));
  const Solid solid = solid_of(joined(parts));
  const Shapes shapes = shapes_of(solid, kMost);
  const auto sites = sites_by_frame(plan_sites(solid, by_shape(50), {}).value());
  for (const auto& [frame, of_frame] : sites)
    if (frame != shapes.frame_of_part[0]) {
      EXPECT_EQ(of_frame.size(), 1u) << frame;
    }
  EXPECT_EQ(sites.size(), kMost - 1) << "what shares a frame has none before fill_frames()";
}

TEST(RadialByParts, OfManyPartsThatHaveLessThanAPieceEachTheOneThatIsHitBreaks) {
  std::vector<Mesh> prisms;
  for (int k = 0; k < 100; ++k)
    prisms.push_back(box({1.0 * (k % 10), 1.0 * (k / 10 % 5), 1.0 * (k / 50)},
                         {1.0 * (k % 10) + 0.2, 1.0 * (k / 10 % 5) + 0.4, 1.0 * (k / 50) + 0.2}));
  const Solid solid = solid_of(joined(prisms));
  const SitePlan plan = plan_sites(solid, by_shape(50, {{3.1, 0.4, 0.1}}), {}).value();
  std::size_t in_it = 0;
  for (const Vec3d& site : plan.points) {
    const Vec3d place = plan.map.at(site).place(site);
    in_it += place.x > 2.9 && place.x < 3.3 && place.y > -0.1 && place.y < 0.5 && place.z < 0.3;
  }
  EXPECT_GE(in_it, 4u);
}

TEST(RadialByParts, AWheelHasNoSitesInPartsThatShareItsFrame) {
  constexpr int kSide = 4;
  std::vector<Mesh> cubes;
  for (int k = 0; k < kSide * kSide * kSide; ++k) {
    const Vec3d low{1.02 * (k % kSide), 1.02 * (k / kSide % kSide), 1.02 * (k / kSide / kSide)};
    cubes.push_back(box(low, low + Vec3d{1, 1, 1}, 2));
  }
  const Solid solid = solid_of(joined(cubes));
  const Shapes shapes = shapes_of(solid, kMost);
  const auto sites = sites_by_frame(plan_sites(solid, by_shape(20 * kSide * kSide * kSide), {}).value());
  std::vector<std::size_t> alone, shared;
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    const auto& of_frame = sites.at(shapes.frame_of_part[p]);
    (shapes.frame_of_part[p] == kMost - 1 ? shared : alone)
        .push_back(
            static_cast<std::size_t>(std::count_if(of_frame.begin(), of_frame.end(), [&](const Vec3d& site) {
              return square_distance(solid.parts[p].box, site) < 1e-9;
            })));
  }
  const auto mean = [](const std::vector<std::size_t>& counts) {
    double sum = 0;
    for (const std::size_t count : counts) sum += static_cast<double>(count);
    return sum / static_cast<double>(counts.size());
  };
  ASSERT_EQ(alone.size(), kMost - 1);
  EXPECT_GT(mean(alone), 3);
  EXPECT_NEAR(mean(shared) / mean(alone), 1, 0.35);
}

TEST(RadialByParts, CrumbsAreInThePartThatIsHit) {
  // The hit is at the corner of the box that is farthest from the tetrahedron, so none of the tetrahedron is
  // crushed.
  const Solid solid =
      solid_of(joined({tetrahedron(), translated(cube(2), {8, 0, 0}), translated(cube(2), {16, 0, 0})}));
  const std::size_t hit = static_cast<std::size_t>(
      std::min_element(solid.parts.begin(), solid.parts.end(),
                       [](const Part& a, const Part& b) { return a.volume < b.volume; }) -
      solid.parts.begin());
  std::set<std::size_t> in_others;
  const Box& around = solid.parts[hit].box;
  for (int corner = 0; corner < 8; ++corner) {
    SiteParameters p =
        by_shape(200, {{corner & 1 ? around.max.x : around.min.x, corner & 2 ? around.max.y : around.min.y,
                        corner & 4 ? around.max.z : around.min.z}});
    for (const double crushed : {0.0, 0.9}) {
      std::get<RadialPattern>(p.pattern).crushed = crushed;
      std::size_t others = 0;
      const Shapes shapes = shapes_for(solid, p);
      for (const auto& [frame, of_frame] : sites_by_frame(plan_sites(solid, p, {}).value()))
        others += frame == shapes.frame_of_part[hit] ? 0 : of_frame.size();
      in_others.insert(others);
    }
  }
  EXPECT_EQ(in_others.size(), 1u) << "as many, crushed or not";
}

TEST(RadialByParts, AWheelThatIsGivenIsOneForAll) {
  const Solid solid = solid_of(laid_table());
  const auto has_map = [&](const RadialPattern& pattern) {
    SiteParameters p = by_shape(50);
    p.pattern = pattern;
    return static_cast<bool>(map_of_cells(solid, p, {}).value());
  };
  using Around = RadialPattern::Around;
  EXPECT_TRUE(has_map({.around = Around::kShape}));
  EXPECT_FALSE(has_map({.around = Around::kShape, .axis = Vec3d{0, 1, 0}}));
  EXPECT_FALSE(has_map({.around = Around::kShape, .spokes = 12}));
  EXPECT_FALSE(has_map({.around = Around::kShape, .rings = 4}));
  EXPECT_FALSE(has_map({.around = Around::kPoint}));
  EXPECT_FALSE(has_map({}));
}

TEST(RadialByParts, NoMoreSitesThanAreAllowed) {
  SiteParameters p = by_shape(2000);
  p.most_sites = 500;
  const auto plan = plan_sites(solid_of(laid_table()), p, {});
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ErrorCode::kTooComplex);
}

}  // namespace
}  // namespace fracture::test
