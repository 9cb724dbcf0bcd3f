#include "common/surface_color/color_groups.hpp"

#include <gtest/gtest.h>

namespace fracture {
namespace {

TEST(ColorGroups, WhatLooksAlikeIsOneGroupWithItsMean) {
  ColorHistogram colors;
  colors.add({30000, 20000, 10000}, 3);
  colors.add({31000, 20000, 10000}, 1);
  const ColorGroups groups = colors.groups(16, 0.1);
  ASSERT_EQ(groups.means.size(), 1u);
  EXPECT_EQ(groups.means[0], (LinearColor{30250, 20000, 10000}));
}

TEST(ColorGroups, DifferentColorsStayApartTheHeaviestFirst) {
  const LinearColor red{65535, 0, 0}, green{0, 65535, 0}, blue{0, 0, 65535};
  ColorHistogram colors;
  for (const auto& [color, weight] : {std::pair{red, 1.0}, {green, 5.0}, {red, 1.0}, {blue, 3.0}})
    colors.add(color, weight);
  const ColorGroups groups = colors.groups(16, 0.1);
  EXPECT_EQ(groups.means, (std::vector<LinearColor>{green, blue, red}));
  EXPECT_EQ(groups.of(red), 2u);
  EXPECT_EQ(groups.of(green), 0u);
  EXPECT_EQ(groups.of(blue), 1u);
}

TEST(ColorGroups, MoreThanMayBeAreJoinedWithTheirNeighbours) {
  ColorHistogram colors;
  std::vector<LinearColor> reds;
  for (std::uint32_t k = 0; k < 1000; ++k) {
    reds.push_back({static_cast<std::uint16_t>(65 * k), 0, 0});
    colors.add(reds.back(), 1 + k % 7 * 0.1);
  }
  const ColorGroups groups = colors.groups(4, 0);
  ASSERT_EQ(groups.means.size(), 4u);
  std::size_t changes = 0;
  for (std::size_t k = 1; k < reds.size(); ++k) changes += groups.of(reds[k]) != groups.of(reds[k - 1]);
  EXPECT_EQ(changes, 3u) << "each group is a range of the reds";
}

TEST(ColorGroups, OfNothingThereAreNoneAndClearedIsNothing) {
  ColorHistogram colors;
  EXPECT_TRUE(colors.groups(16, 0).means.empty());
  colors.add({1, 2, 3}, 1);
  EXPECT_FALSE(colors.empty());
  colors.clear();
  EXPECT_TRUE(colors.empty());
  EXPECT_TRUE(colors.groups(16, 0).means.empty());
  colors.add({40000, 50000, 60000}, 2);
  colors.add({1, 2, 3}, 1);                                                                 // as first added
  EXPECT_EQ(colors.groups(1, 0).means, (std::vector<LinearColor>{{26667, 33334, 40001}}));  // (2 a + b) / 3
}

}  // namespace
}  // namespace fracture
