#include "common/base/shared_blocks.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <vector>

#include "common/base/id_table.hpp"
#include "common/base/random.hpp"
#include "common/base/ranked_set.hpp"

namespace fracture {
namespace {

using Numbers = SharedBlocks<int, 4>;

std::vector<int> all_of(const Numbers& numbers) {
  std::vector<int> all;
  for (std::size_t k = 0; k < numbers.size(); ++k) all.push_back(numbers[k]);
  return all;
}

TEST(SharedBlocks, ACopyKeepsWhatTheOtherOneChanges) {
  for (const std::size_t size : {0u, 1u, 3u, 4u, 5u, 8u, 13u}) {
    SCOPED_TRACE(size);
    std::vector<int> expected(size);
    std::iota(expected.begin(), expected.end(), 0);
    Numbers now{std::vector<int>(expected)};
    const std::vector<int> before = expected;
    const Numbers copy = now;
    {
      Numbers::Edit edit(now);
      for (std::size_t k = 0; k < size; k += 2) {
        edit.at(k) += 100;
        expected[k] += 100;
      }
      for (int k = 0; k < 6; ++k) {
        edit.push_back(1000 + k);
        expected.push_back(1000 + k);
        EXPECT_EQ(edit[expected.size() - 1], 1000 + k);
      }
      edit.at(expected.size() - 1) = 7;
      expected.back() = 7;
    }
    EXPECT_EQ(all_of(now), expected);
    EXPECT_EQ(all_of(copy), before);
    // From here on both grow in blocks that they shared.
    Numbers other = now;
    Numbers::Edit(now).push_back(1);
    Numbers::Edit(other).push_back(2);
    EXPECT_EQ(now[expected.size()], 1);
    EXPECT_EQ(other[expected.size()], 2);
    EXPECT_EQ(all_of(copy), before);
  }
}

TEST(SharedBlocks, SharesWhatDidNotChange) {
  std::vector<std::shared_ptr<const int>> all;
  for (int k = 0; k < 12; ++k) all.push_back(std::make_shared<const int>(k));
  SharedBlocks<std::shared_ptr<const int>, 4> now{std::move(all)};
  const auto copy = now;
  SharedBlocks<std::shared_ptr<const int>, 4>::Edit(now).at(5) = std::make_shared<const int>(50);
  EXPECT_EQ(&copy[0], &now[0]) << "the same memory";
  EXPECT_EQ(&copy[11], &now[11]);
  EXPECT_NE(&copy[4], &now[4]) << "its block was copied";
  EXPECT_EQ(*copy[5], 5);
  EXPECT_EQ(*now[5], 50);
  EXPECT_EQ(copy[4], now[4]);
}

TEST(IdTable, IsAMap) {
  Random random(3);
  IdTable table;
  std::vector<std::uint32_t> expected(5000, IdTable::kEmpty);
  EXPECT_EQ(table.find(1), IdTable::kEmpty);
  for (std::uint32_t k = 0; k < 2000; ++k) {
    const std::uint32_t id = random() % 5000;
    EXPECT_EQ(table.slot(id), expected[id]);
    table.slot(id) = expected[id] = k;
  }
  std::size_t size = 0;
  for (std::uint32_t id = 0; id < expected.size(); ++id) {
    EXPECT_EQ(table.find(id), expected[id]);
    size += expected[id] != IdTable::kEmpty;
  }
  EXPECT_EQ(table.size(), size);
}

TEST(RankedSet, KnowsTheRanksOfItsMembers) {
  for (const std::uint32_t n : {0u, 1u, 63u, 64u, 65u, 1000u}) {
    SCOPED_TRACE(n);
    Random random(n);
    RankedSet set(n);
    std::vector<std::uint32_t> members, visited;
    for (std::uint32_t k = 0; k < n; ++k)
      if (random() % 3 == 0) {
        members.push_back(k);
        set.add(k);
      }
    set.close();
    set.each([&](std::uint32_t k) { visited.push_back(k); });
    EXPECT_EQ(visited, members);
    EXPECT_EQ(set.size(), members.size());
    std::uint32_t rank = 0;
    for (std::uint32_t k = 0; k < n; ++k) {
      EXPECT_EQ(set.rank(k), rank);
      const bool is_member = rank < members.size() && members[rank] == k;
      EXPECT_EQ(set.contains(k), is_member);
      rank += is_member;
    }
  }
}

}  // namespace
}  // namespace fracture
