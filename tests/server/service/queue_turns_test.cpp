// The order in which names take turns in the queue of the worker pool, and how many tasks may wait.
#include <gtest/gtest.h>

#include <algorithm>
#include <latch>
#include <string>
#include <vector>

#include "server/service/worker_pool.hpp"
#include "tests/server/service/polling.hpp"
#include "tests/support/eventually.hpp"

namespace fracture {
namespace {

using test::kBatch, test::kRealtime;

TEST(Turns, TwoNamesOneAtTenTimesItsShareAreServedInTurn) {
  std::latch gate(1);
  WorkerPool pool(1, 1000);
  pool.submit(kBatch, 0, [&](int) { gate.wait(); });
  test::require_eventually(test::kPatience, "a job to run", [&] { return pool.running() > 0; });
  std::string order;
  const auto add = [&](const char* name) {
    const auto task = [&order, name](int) {
      order += name;
      WorkerPool::turn()->spent_elsewhere(0.1);
    };
    return pool.submit(kBatch, 0.1, task, {name, 1});
  };
  for (int k = 0; k < 100; ++k) add("a");
  std::vector<WorkerPool::TaskId> quiet;
  for (int k = 0; k < 10; ++k) quiet.push_back(add("b"));
  const auto positions = pool.positions(quiet);
  for (std::size_t k = 0; k < quiet.size(); ++k) EXPECT_EQ(positions[k], 2 * k + 1);
  EXPECT_LT(pool.predicted_wait(kBatch, {"c", 1}).count(), 0.01) << "not all 110";
  gate.count_down();
  pool.wait_idle();
  const std::string first = order.substr(0, 20);
  EXPECT_EQ(std::count(first.begin(), first.end(), 'b'), 10) << first;
}

TEST(Turns, WhoFillsTheQueueLeavesTheOthersTheirPart) {
  std::latch gate(1);
  WorkerPool pool(1, 10);
  pool.submit(kBatch, 0, [&](int) { gate.wait(); });
  test::require_eventually(test::kPatience, "a job to run", [&] { return pool.running() > 0; });
  const Flow a{"a", 1}, b{"b", 1};
  for (int k = 0; k < 10; ++k) {
    EXPECT_FALSE(pool.full(kBatch, a)) << k;
    pool.submit(
        kBatch, 1, [](int) {}, a);
  }
  EXPECT_TRUE(pool.full(kBatch, a));
  // The second client may have half of the free places (FairShare): 3 of 20 - 13, not 4 of 20 - 14.
  for (int k = 0; k < 3; ++k) {
    EXPECT_FALSE(pool.full(kBatch, b)) << k;
    pool.submit(
        kBatch, 1, [](int) {}, b);
  }
  EXPECT_TRUE(pool.full(kBatch, b));
  gate.count_down();
  pool.wait_idle();
}

TEST(Turns, HoweverManyComeNoMoreWaitThanFourTimesWhatMay) {
  std::latch gate(1);
  WorkerPool pool(1, 10);
  pool.submit(kBatch, 0, [&](int) { gate.wait(); });
  test::require_eventually(test::kPatience, "a job to run", [&] { return pool.running() > 0; });
  for (int k = 0; k < 1000; ++k) {
    const Flow flow{"address " + std::to_string(k), 1};
    if (pool.full(kBatch, flow)) continue;
    pool.submit(
        k % 2 == 0 ? kBatch : Priority::kRealtime, 1, [](int) {}, flow);
  }
  EXPECT_EQ(pool.queued(), 40u);
  EXPECT_TRUE(pool.full(kBatch, {"address of somebody else", 1}));
  gate.count_down();
  pool.wait_idle();
}

TEST(Turns, WhoIsInAHurryGivesTheTurnOfWhatItPromotes) {
  std::latch gate(1);
  WorkerPool pool(1, 100);
  pool.submit(kBatch, 0, [&](int) { gate.wait(); });
  test::require_eventually(test::kPatience, "a job to run", [&] { return pool.running() > 0; });
  const Flow a{"a", 1}, b{"b", 1};
  std::string order;
  const auto add = [&](Priority priority, double cost, const Flow& flow, char name) {
    const auto task = [&order, name, cost](int) {
      order += name;
      WorkerPool::turn()->spent_elsewhere(cost);
    };
    return pool.submit(priority, cost, task, flow);
  };
  const WorkerPool::TaskId promoted = add(kBatch, 0.5, a, 'p');
  add(Priority::kRealtime, 0.1, a, '1');
  EXPECT_TRUE(pool.reclassify(promoted, kRealtime, b));
  EXPECT_FALSE(pool.reclassify(promoted, kRealtime, b)) << "it is one already";
  add(Priority::kRealtime, 0.1, a, '2');
  add(Priority::kRealtime, 0.1, b, '3');
  gate.count_down();
  pool.wait_idle();
  EXPECT_EQ(order, "p123") << "b has had half a second by then, and a less";
}

}  // namespace
}  // namespace fracture
