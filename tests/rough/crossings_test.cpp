#include "common/rough/crossings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <stop_token>

#include "common/solid/corners.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

std::array<CutVertexId, 3> triangle(int a, int b, int c) {
  return {CutVertexId{a}, CutVertexId{b}, CutVertexId{c}};
}

/// Two parallel square caps. The tests lift one corner of the lower cap.
struct TwoCaps {
  Solid solid = *make_solid(std::make_shared<Mesh>(cube()), {}, {});
  SurfaceTree outside{corners_of(solid)};
  std::vector<std::array<CutVertexId, 3>> triangles{triangle(10, 11, 12), triangle(10, 12, 13),
                                                    triangle(14, 15, 16), triangle(14, 16, 17)};
  std::vector<Vec3d> points{{-0.2, -0.2, 0},   {0.2, -0.2, 0},   {0.2, 0.2, 0},   {-0.2, 0.2, 0},
                            {-0.2, -0.2, 0.1}, {0.3, -0.3, 0.1}, {0.3, 0.3, 0.1}, {-0.2, 0.2, 0.1}};
  std::vector<Vec3d> flat = points;
  std::vector<char> moved = std::vector<char>(8, 0), crossing;
  std::vector<double> surface = std::vector<double>(8, 0.1);

  std::vector<std::uint32_t> place{0, 1, 2, 3, 4, 5, 6, 7};
  std::vector<char> seen = std::vector<char>(4, 1);
  std::vector<std::uint32_t> region_begin{0, 2, 4};

  /// Adds caps of one triangle each.
  void add(std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      triangles.push_back(triangle(10, 11, 12));
      region_begin.push_back(static_cast<std::uint32_t>(triangles.size()));
    }
    seen.assign(triangles.size(), 1);
  }
  CapSurface surfaces() const {
    return {triangles, region_begin, seen, CutVertexId{10}, points, flat, moved, surface, place};
  }
  std::optional<std::uint64_t> find() {
    Crossings crossings(surfaces(), outside, 1e-9);
    return crossings.find({}, crossing, {});
  }
};

TEST(CrossingsOfCaps, NamesBothTrianglesOfAPairWithAMovedVertex) {
  TwoCaps caps;
  EXPECT_EQ(caps.find(), 0u);
  caps.points[1] = {0.2, -0.2, 0.2};  // a corner of triangle 0 only, through triangle 2
  EXPECT_EQ(caps.find(), 0u) << "nothing was moved: that is how the input is";
  caps.moved[1] = 1;
  EXPECT_EQ(caps.find(), 1u);
  EXPECT_EQ(caps.crossing, (std::vector<char>{1, 0, 1, 0}));
}

TEST(CrossingsOfCaps, ATriangleThatLeavesTheSurfaceCountsAlone) {
  TwoCaps caps;
  caps.points[1] = {0.2, -0.2, 0.2};  // through triangle 2
  caps.points[7] = {-0.2, 0.2, 0.6};  // a corner of triangle 3, out of the cube
  caps.moved[1] = caps.moved[7] = 1;
  EXPECT_EQ(caps.find(), 2u);
  EXPECT_EQ(caps.crossing, (std::vector<char>{1, 0, 1, 1}));
}

TEST(CrossingsOfCaps, LooksAgainAtWhatHasMovedSince) {
  TwoCaps caps;
  caps.points[1] = {0.2, -0.2, 0.2};
  caps.moved[1] = 1;
  Crossings crossings(caps.surfaces(), caps.outside, 1e-9);
  EXPECT_EQ(crossings.find({}, caps.crossing, {}), 1u);
  EXPECT_EQ(crossings.find({0, 1, 0, 1}, caps.crossing, {}), 0u) << "neither has moved since";
  EXPECT_EQ(crossings.find({0, 0, 1, 0}, caps.crossing, {}), 1u);
  EXPECT_EQ(crossings.find({1, 0, 1, 0}, caps.crossing, {}), 1u) << "a pair counts once";
  caps.points[1] = {0.2, -0.2, 0.05};
  EXPECT_EQ(crossings.find({1, 0, 0, 0}, caps.crossing, {}), 0u);
  EXPECT_EQ(caps.crossing, (std::vector<char>{0, 0, 0, 0}));
}

TEST(CrossingsOfCaps, LeavesTrianglesOfOneRegionToWhoeverSeesThemTurnOver) {
  TwoCaps caps;
  caps.points[1] = {0.2, -0.2, 0.2};
  caps.moved[1] = 1;
  caps.region_begin = {0, 4};
  EXPECT_EQ(caps.find(), 0u);
}

TEST(CrossingsOfCaps, WhatIsNoCutIsInNobodysWay) {
  TwoCaps caps;
  caps.points[1] = {0.2, -0.2, 0.2};
  caps.moved[1] = 1;
  caps.seen[2] = 0;
  EXPECT_EQ(caps.find(), 0u);
}

TEST(CrossingsOfCaps, GivesUpWhereAllLieInEachOthersBoxes) {
  TwoCaps caps;
  caps.add(3 * Crossings::kMostPairs);
  EXPECT_EQ(caps.find(), 0u) << "nothing was moved: nobody asks";
  caps.moved[0] = 1;
  EXPECT_EQ(caps.find(), std::nullopt);
}

TEST(CrossingsOfCaps, FindsTheSameWhereOnlyFewAreMoved) {
  TwoCaps caps;
  caps.points[7] = {0.15, -0.05, -0.1};  // a corner of triangle 3, through triangle 0
  caps.moved[7] = 1;
  const std::uint64_t few = caps.find().value();  // of four triangles: all pairs are tested
  ASSERT_TRUE(caps.crossing[0]);
  caps.add(100);  // like triangle 0, never moved; only triangle 3 looks for crossings
  EXPECT_EQ(caps.find(), few + 100);
}

TEST(CrossingsOfCaps, IsInterrupted) {
  TwoCaps caps;
  caps.add(1000);
  caps.moved[0] = 1;
  std::stop_source stop;
  stop.request_stop();
  Execution execution;
  execution.stop = stop.get_token();
  Crossings crossings(caps.surfaces(), caps.outside, 1e-9);
  EXPECT_THROW(crossings.find({}, caps.crossing, execution), Interrupted);
}

TEST(CrossingsOfCaps, SeesTheOuterSurface) {
  TwoCaps caps;
  caps.points[7] = {-0.2, 0.2, 0.6};  // out of the top of the cube
  caps.moved[7] = 1;
  EXPECT_EQ(caps.find(), 1u);
  EXPECT_EQ(caps.crossing, (std::vector<char>{0, 0, 0, 1}));
}

}  // namespace
}  // namespace fracture::test
