#include "common/base/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace fracture {
namespace {

TEST(Random, MatchesTheReferenceSequenceOfSplitMix64) {
  // Expected values: from the authors' splitmix64.c with state 1234567.
  Random random(1234567);
  for (const std::uint64_t expected : {6457827717110365317ull, 3203168211198807973ull, 9817491932198370423ull,
                                       4593380528125082431ull, 16408922859458223821ull})
    EXPECT_EQ(random(), expected);
}

TEST(Random, UniformStaysInTheHalfOpenUnitIntervalOnTheLatticeOf2ToTheMinus53) {
  Random random(7);
  for (int i = 0; i < 10000; ++i) {
    const double x = random.uniform();
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    const double scaled = x * 0x1.0p53;
    ASSERT_EQ(scaled, static_cast<double>(static_cast<std::uint64_t>(scaled)));
  }
}

TEST(Random, BelowOneIsAlwaysZero) {
  Random random(3);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(random.below(1), 0u);
}

TEST(Random, BelowIsUnbiasedForABoundThatDoesNotDivideTheRange) {
  // Chi-square with 6 degrees of freedom. Chance exceeds 22.5 once in a thousand runs.
  Random random(11);
  std::array<double, 7> counts{};
  constexpr int kDraws = 70000;
  for (int i = 0; i < kDraws; ++i) ++counts[random.below(7)];
  double chi = 0;
  for (const double c : counts) chi += (c - kDraws / 7.0) * (c - kDraws / 7.0) / (kDraws / 7.0);
  EXPECT_LT(chi, 22.5);
}

TEST(Random, BelowStaysBelowBoundsNearTheWholeRange) {
  Random random(13);
  const std::uint64_t bound = (1ull << 63) + 1;  // rejects almost half of the draws
  for (int i = 0; i < 1000; ++i) EXPECT_LT(random.below(bound), bound);
}

TEST(Shuffle, IsAPermutationAndDependsOnTheSeedOnly) {
  std::vector<int> items(100);
  for (int i = 0; i < 100; ++i) items[i] = i;
  std::vector<int> a = items, b = items, c = items;
  Random first(5), second(5), third(6);
  shuffle(a, first);
  shuffle(b, second);
  shuffle(c, third);
  EXPECT_EQ(a, b);
  EXPECT_NE(a, c);
  std::sort(a.begin(), a.end());
  EXPECT_EQ(a, items);
}

}  // namespace
}  // namespace fracture
