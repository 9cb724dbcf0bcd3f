// Tests of the threads that are not allowed to work on many bytes at once.
#include "common/base/bulk.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "common/base/json_reader.hpp"

namespace fracture {
namespace {

struct Bulk : testing::Test {
  BulkLimit limit{1000};
  void SetUp() override { limit_bulk(&limit); }
  void TearDown() override { limit_bulk(nullptr); }
};

TEST_F(Bulk, ATurnOverTheLimitIsCountedOnce) {
  count_bulk(600);
  count_bulk(400);
  EXPECT_EQ(limit.exceeded, 0u) << "as much as it may";
  count_bulk(1);
  count_bulk(5000);
  EXPECT_EQ(limit.exceeded, 1u);
  begin_bulk_turn();
  count_bulk(1000);
  EXPECT_EQ(limit.exceeded, 1u);
  begin_bulk_turn();
  count_bulk(1001);
  EXPECT_EQ(limit.exceeded, 2u);
}

TEST_F(Bulk, OtherThreadsMayDoWhatTheyLike) {
  std::thread([] { count_bulk(1u << 30); }).join();
  limit_bulk(nullptr);
  count_bulk(1u << 30);
  EXPECT_EQ(limit.exceeded, 0u);
}

TEST_F(Bulk, ParsingCountsForMoreThanItsBytes) {
  EXPECT_TRUE(read_json("[1]", {}));
  EXPECT_EQ(limit.exceeded, 0u);
  EXPECT_TRUE(read_json("[" + std::string(998, ' ') + "]", {}));
  EXPECT_EQ(limit.exceeded, 1u);
}

}  // namespace
}  // namespace fracture
