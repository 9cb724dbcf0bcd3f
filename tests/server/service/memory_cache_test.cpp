#include "server/cache/memory_cache.hpp"

#include <gtest/gtest.h>

#include <string>

namespace fracture {
namespace {

using Cache = MemoryCache<int>;

std::shared_ptr<const int> value(int n) { return std::make_shared<const int>(n); }

TEST(MemoryCache, OfEntriesNobodyAskedForAgainTheOldestLeavesFirst) {
  Cache cache(30);
  for (const char* key : {"a", "b", "c", "d"}) EXPECT_TRUE(cache.insert(key, value(1), 10));
  EXPECT_FALSE(cache.find("a"));
  for (const char* key : {"b", "c", "d"}) EXPECT_TRUE(cache.find(key)) << key;
  EXPECT_EQ(cache.figures().bytes, 30u);
  EXPECT_EQ(cache.figures().evictions, 1u);
}

TEST(MemoryCache, WhatIsAskedForAgainSurvivesAScanOfAnyLength) {
  Cache cache(100);
  for (int k = 0; k < 5; ++k) cache.insert("hot" + std::to_string(k), value(k), 10);
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(cache.find("hot" + std::to_string(k)));
  for (int k = 0; k < 1000; ++k) cache.insert("scan" + std::to_string(k), value(k), 10);
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(cache.find("hot" + std::to_string(k))) << k;
  EXPECT_LE(cache.figures().bytes, 100u);
}

TEST(MemoryCache, WhatComesBackSoonAfterItsEvictionIsKeptLonger) {
  Cache cache(100);
  for (int k = 0; k < 11; ++k) cache.insert(std::to_string(k), value(k), 10);
  ASSERT_FALSE(cache.find("0"));
  cache.insert("0", value(0), 10);  // The key is remembered, so the entry goes straight to the main queue.
  for (int k = 100; k < 108; ++k) cache.insert(std::to_string(k), value(k), 10);
  EXPECT_TRUE(cache.find("0"));
}

TEST(MemoryCache, WhatWasHotIsForgottenWhenOthersAreAskedForInstead) {
  Cache cache(50);
  for (int k = 0; k < 5; ++k) cache.insert("old" + std::to_string(k), value(k), 10);
  for (int round = 0; round < 5; ++round)
    for (int k = 0; k < 5; ++k) cache.find("old" + std::to_string(k));
  for (int round = 0; round < 20; ++round)
    for (int k = 0; k < 5; ++k) {
      const std::string key = "new" + std::to_string(k);
      if (!cache.find(key)) cache.insert(key, value(k), 10);
    }
  int kept = 0;
  for (int k = 0; k < 5; ++k) kept += cache.find("new" + std::to_string(k)) != nullptr;
  EXPECT_GE(kept, 4);
}

TEST(MemoryCache, AnEntryOverTheBudgetIsNotKeptAndEvictsNothing) {
  Cache cache(30);
  cache.insert("a", value(1), 30);
  EXPECT_FALSE(cache.insert("big", value(1), 31));
  EXPECT_TRUE(cache.find("a"));
}

TEST(MemoryCache, ReplacingAnEntryCountsItOnce) {
  Cache cache(30);
  cache.insert("a", value(1), 20);
  cache.insert("a", value(2), 25);
  EXPECT_EQ(cache.figures().bytes, 25u);
  EXPECT_EQ(cache.figures().entries, 1u);
  EXPECT_EQ(*cache.find("a"), 2);
  cache.erase("a");
  EXPECT_EQ(cache.figures().bytes, 0u);
}

TEST(MemoryCache, AnEvictedValueLivesAsLongAsItsReaders) {
  Cache cache(10);
  cache.insert("a", value(7), 10);
  const auto held = cache.find("a");
  for (const char* key : {"b", "c", "d", "e", "f"}) cache.insert(key, value(8), 10);
  EXPECT_FALSE(cache.find("a"));
  EXPECT_EQ(*held, 7);
}

TEST(MemoryCache, BytesStayWithinTheBudgetForAnyOrderOfSizesAndUses) {
  Cache cache(1000);
  std::uint64_t state = 12345;  // a linear congruential generator, so that the test is the same everywhere
  const auto random = [&](std::uint64_t n) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (state >> 33) % n;
  };
  for (int i = 0; i < 20000; ++i) {
    const std::string key = std::to_string(random(60));
    switch (random(4)) {
      case 0:
        cache.erase(key);
        break;
      case 1:
        cache.insert(key, value(i), 1 + random(400));
        break;
      default:
        cache.find(key);
    }
    ASSERT_LE(cache.figures().bytes, 1000u) << i;
  }
}

}  // namespace
}  // namespace fracture
