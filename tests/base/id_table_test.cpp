#include "common/base/id_table.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "common/base/random.hpp"
#include "common/base/ranked_set.hpp"

namespace fracture {
namespace {

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
