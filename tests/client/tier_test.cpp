// The tier that the window draws, as a function of the time that its pictures took.
#include "client/render/tier.hpp"

#include <gtest/gtest.h>

namespace fracture::test {
namespace {

using render::Tier;
using render::TierChoice;

/// Plays this many pictures, whose times depend on the tier. Returns how often the tier changed.
int play(TierChoice& choice, int pictures, double low_ms, double high_ms) {
  int changes = 0;
  for (int k = 0; k < pictures; ++k) {
    const Tier before = choice.tier();
    choice.add(before == Tier::kLow ? low_ms : high_ms);
    changes += choice.tier() != before;
  }
  return changes;
}

TEST(TierChoice, BeginsLowAndGoesUpWhereThereIsRoom) {
  TierChoice choice;
  EXPECT_EQ(choice.tier(), Tier::kLow);
  EXPECT_EQ(play(choice, 20, 0.5, 4), 0) << "after a third of a second nothing is known";
  EXPECT_EQ(play(choice, 1000, 0.5, 4), 1);
  EXPECT_EQ(choice.tier(), Tier::kHigh);
}

TEST(TierChoice, StaysLowWithoutClearRoom) {
  for (const double low_ms : {4.0, 8.0, 16.0, 60.0}) {
    TierChoice choice;
    EXPECT_EQ(play(choice, 5000, low_ms, 8 * low_ms), 0) << low_ms;
    EXPECT_EQ(choice.tier(), Tier::kLow);
  }
}

TEST(TierChoice, GoesDownOnceMostPicturesAreTooSlow) {
  TierChoice choice;
  play(choice, 200, 0.5, 4);
  ASSERT_EQ(choice.tier(), Tier::kHigh);
  EXPECT_EQ(play(choice, 100, 0.5, 40), 1);
  EXPECT_EQ(choice.tier(), Tier::kLow);
}

TEST(TierChoice, ASlowPictureNowAndThenChangesNothing) {
  TierChoice choice;
  play(choice, 200, 0.5, 4);
  ASSERT_EQ(choice.tier(), Tier::kHigh);
  for (int k = 0; k < 3000; ++k) {
    choice.add(k % 3 == 0 ? 120 : 8);
    ASSERT_EQ(choice.tier(), Tier::kHigh) << k;
  }
  // Times between too slow and fast enough change nothing in either tier.
  EXPECT_EQ(play(choice, 3000, 10, 20), 0);
}

TEST(TierChoice, NeverFlipsBackAndForth) {
  // A card that is fast with low pictures and far too slow for high ones, for three hours.
  TierChoice choice;
  EXPECT_LE(play(choice, 600'000, 1, 50), 4) << "up, down, and once more";
  EXPECT_EQ(choice.tier(), Tier::kLow);
  // The second wait is longer than the first.
  TierChoice other;
  int first = 0, second = 0;
  while (other.tier() == Tier::kLow && first < 10'000) other.add(1), ++first;
  while (other.tier() == Tier::kHigh) other.add(50);
  while (other.tier() == Tier::kLow && second < 10'000) other.add(1), ++second;
  EXPECT_EQ(other.tier(), Tier::kHigh);
  EXPECT_GT(second, 5 * first);
}

TEST(TierChoice, WhatANewTierTakesAtFirstIsNoMeasure) {
  TierChoice choice;
  while (choice.tier() == Tier::kLow) choice.add(0.5);
  for (int k = 0; k < 10; ++k) choice.add(400);  // while shaders are compiled
  EXPECT_EQ(play(choice, 300, 0.5, 5), 0);
  EXPECT_EQ(choice.tier(), Tier::kHigh);
}

TEST(TierChoice, SoftwareStaysLowHoweverQuickItIs) {
  TierChoice choice(true);
  EXPECT_EQ(play(choice, 5000, 0.1, 0.1), 0);
  EXPECT_EQ(choice.tier(), Tier::kLow);
  EXPECT_TRUE(render::draws_in_software("llvmpipe (LLVM 14.0.6, 256 bits)"));
  EXPECT_TRUE(render::draws_in_software("Google SwiftShader"));
  EXPECT_TRUE(render::draws_in_software("Software Rasterizer"));
  EXPECT_FALSE(render::draws_in_software("Mesa Intel(R) UHD Graphics 620 (KBL GT2)"));
  EXPECT_FALSE(render::draws_in_software("NVIDIA GeForce RTX 3060/PCIe/SSE2"));
}

}  // namespace
}  // namespace fracture::test
