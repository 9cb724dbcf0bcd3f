// Support, computed by hand: blocks of known weight, bonds with known cross-sections.
#include "common/structure/support.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/gltf/report_text.hpp"
#include "common/structure/anchors.hpp"
#include "tests/structure/blocks.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

constexpr double kG = 10, kDensity = 100, kPi = 3.141592653589793;

SupportOptions options() {
  SupportOptions o;
  o.gravity = {0, -kG, 0};
  o.density = kDensity;
  return o;
}

/// Unit cubes with their centres at the given positions; tests add the bonds between neighbours by hand.
struct Blocks : FragmentSet {
  AnchoredFragments anchored;
};
Blocks blocks(const std::vector<Vec3d>& centers, const std::vector<std::uint32_t>& anchored) {
  Blocks set;
  for (std::size_t k = 0; k < centers.size(); ++k) set.fragments.push_back(block(100 + k, centers[k]));
  set.anchored = {std::vector<char>(centers.size(), 0), static_cast<std::uint32_t>(anchored.size())};
  for (const std::uint32_t k : anchored) set.anchored.held[k] = 1;
  return set;
}

TEST(Support, TowerCarriesTheWeightAboveEachBond) {
  Blocks set = blocks({{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}}, {0});
  for (std::uint32_t k = 0; k < 3; ++k) bind(set, k, k + 1);
  const Support s = analyze_support(set, set.anchored, options(), {});
  EXPECT_LE(s.residual, 1e-8);
  EXPECT_TRUE(s.falling.empty());
  ASSERT_EQ(s.loads.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(s.loads[k].tension, -kDensity * kG * static_cast<double>(3 - k), 1e-4);
    EXPECT_NEAR(s.loads[k].shear, 0, 1e-4);
    EXPECT_NEAR(s.loads[k].bending, 0, 1e-4);
    EXPECT_NEAR(s.loads[k].stress, 0, 1e-4);  // under compression
  }
}

TEST(Support, HangingChainPullsItsBonds) {
  Blocks set = blocks({{0, 0, 0}, {0, -1, 0}, {0, -2, 0}}, {0});
  bind(set, 0, 1, 0.5);
  bind(set, 1, 2, 0.25);
  SupportOptions o = options();
  o.strength = 4100;
  const Support s = analyze_support(set, set.anchored, o, {});
  EXPECT_NEAR(s.loads[0].stress, 2 * kDensity * kG / 0.5, 1e-3);   // 4000 Pa
  EXPECT_NEAR(s.loads[1].stress, 1 * kDensity * kG / 0.25, 1e-3);  // 4000 Pa
  EXPECT_TRUE(s.weak.empty());
  o.strength = 3900;
  EXPECT_EQ(analyze_support(set, set.anchored, o, {}).weak.size(), 2u);
}

TEST(Support, CantileverBendsByWeightTimesArm) {
  // Held at x = 0; blocks at 1, 2, 3; bonds at 0.5, 1.5, 2.5.
  Blocks set = blocks({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, {0});
  for (std::uint32_t k = 0; k < 3; ++k) bind(set, k, k + 1);
  const Support s = analyze_support(set, set.anchored, options(), {});
  const double w = kDensity * kG;
  const double moments[] = {w * (0.5 + 1.5 + 2.5), w * (0.5 + 1.5), w * 0.5};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(s.loads[k].shear, w * static_cast<double>(3 - k), 1e-4);
    EXPECT_NEAR(s.loads[k].bending, moments[k], 1e-4);
    EXPECT_NEAR(s.loads[k].tension, 0, 1e-4);
    // A disc of area 1: the rim stress is M r / I = 4 sqrt(π) M, the shear is V, and Rankine's principal
    // stress combines both.
    const double sigma = 4 * std::sqrt(kPi) * moments[k], tau = w * static_cast<double>(3 - k);
    EXPECT_NEAR(s.loads[k].stress, sigma / 2 + std::sqrt(sigma * sigma / 4 + tau * tau), 1e-2);
  }
}

TEST(Support, BridgeSharesItsWeightBetweenItsEnds) {
  Blocks set = blocks({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}}, {0, 4});
  for (std::uint32_t k = 0; k < 4; ++k) bind(set, k, k + 1);
  const Support s = analyze_support(set, set.anchored, options(), {});
  const double w = kDensity * kG;
  EXPECT_NEAR(s.loads[0].shear, 1.5 * w, 1e-4);
  EXPECT_NEAR(s.loads[1].shear, 0.5 * w, 1e-4);
  EXPECT_NEAR(s.loads[2].shear, 0.5 * w, 1e-4);
  EXPECT_NEAR(s.loads[3].shear, 1.5 * w, 1e-4);
  EXPECT_NEAR(s.loads[0].bending, s.loads[3].bending, 1e-4);
}

TEST(Support, WhatHasNoWayToAnAnchorFalls) {
  // A bridge on two piers. If its middle breaks, nothing falls. If one pier breaks, the bridge hangs on the
  // other.
  Blocks set = blocks({{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}, {2, 0, 0}}, {0, 4});
  for (std::uint32_t k = 0; k < 4; ++k) bind(set, k, k + 1);
  SupportOptions o = options();
  o.broken = {102};
  EXPECT_TRUE(analyze_support(set, set.anchored, o, {}).falling.empty());
  o.broken = {101, 103};
  const Support s = analyze_support(set, set.anchored, o, {});
  EXPECT_EQ(s.falling, std::vector<std::uint32_t>{2});
  for (const BondLoad& load : s.loads) EXPECT_EQ(load.stress, 0);
  o.broken = {100};
  EXPECT_TRUE(analyze_support(set, set.anchored, o, {}).falling.empty());
  o.broken = {100, 104};
  EXPECT_EQ(analyze_support(set, set.anchored, o, {}).falling.size(), 3u);
  o.broken = {9};
  EXPECT_EQ(analyze_support(set, set.anchored, o, {}).unknown, 1u);
}

TEST(Support, WithoutAnchorsAllFalls) {
  Blocks set = blocks({{0, 0, 0}, {0, 1, 0}}, {});
  bind(set, 0, 1);
  const Support s = analyze_support(set, set.anchored, options(), {});
  EXPECT_EQ(s.falling.size(), 2u);
  EXPECT_EQ(s.anchored, 0u);
}

TEST(Support, AllTheWeightOfAFracturedPillarGoesThroughItsFoot) {
  const Mesh mesh = box({0, 0, 0}, {1, 4, 1});
  FractureParameters p;
  p.pattern = PointsPattern{random_sites(box_of(mesh), 150, 7)};
  p.anchors.planes.push_back({{0, 1, 0}, 0});
  const Fractured made = fracture_mesh(mesh, p);
  const FragmentSet& set = made.set;
  const Support s = analyze_support(set, made.anchored, options(), {});
  EXPECT_LE(s.residual, 1e-8);
  EXPECT_TRUE(s.falling.empty());
  // The vertical forces across the bonds of the anchored fragments equal the weight of the others. Only the
  // tension along the normal and the length of the shear are given, so the sum is bounded from both sides.
  double weight = 0, most = 0;
  for (std::size_t k = 0; k < set.fragments.size(); ++k)
    weight += made.anchored.contains(k) ? 0 : kDensity * kG * set.fragments[k].mass.volume;
  for (std::size_t k = 0; k < set.bonds.size(); ++k) {
    const Bond& b = set.bonds[k];
    if (made.anchored.contains(b.a) == made.anchored.contains(b.b)) continue;
    most += std::fabs(s.loads[k].tension * b.normal.y) + s.loads[k].shear;
  }
  EXPECT_GE(most, weight * (1 - 1e-6));
  EXPECT_LE(most, 4 * weight);
  JsonText json;
  write_support(json, set, s);
  const nlohmann::json report = nlohmann::json::parse(json.text());
  EXPECT_EQ(report.at("bonds").at("stress").size(), set.bonds.size());
  EXPECT_EQ(report.at("falling").size(), 0u);
}

}  // namespace
}  // namespace fracture::test
