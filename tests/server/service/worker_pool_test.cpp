#include "server/service/worker_pool.hpp"
#include "tests/server/service/polling.hpp"
#include "tests/support/eventually.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <string>
#include <thread>

namespace fracture {
namespace {

using test::kBatch, test::kRealtime;

/// A single thread that is busy until release(), so that the order of queued tasks can be observed.
struct BusyPool {
  explicit BusyPool(std::size_t max_queue = 100, double cost = 0) : pool(1, max_queue) {
    pool.submit(kBatch, cost, [this](int) { gate.wait(); });
    test::require_eventually(test::kPatience, "a job to run", [&] { return pool.running() > 0; });
  }
  ~BusyPool() {
    if (!released) release();
  }
  void release() {
    released = true;
    gate.count_down();
    pool.wait_idle();
  }
  WorkerPool::TaskId add(Priority priority, char name) {
    return pool.submit(priority, 0, [this, name](int) { order += name; });
  }
  std::latch gate{1};
  bool released = false;
  std::string order;
  WorkerPool pool;
};

TEST(WorkerPool, ALoneJobMayUseEveryThreadAndALoadedPoolGivesOneEach) {
  WorkerPool pool(4, 100);
  std::atomic<int> alone{0};
  pool.submit(kBatch, 0, [&](int threads) { alone = threads; });
  pool.wait_idle();
  EXPECT_EQ(alone, 4);

  std::latch all_running(5);
  std::atomic<int> last{0};
  for (int i = 0; i < 3; ++i) pool.submit(kBatch, 0, [&](int) { all_running.arrive_and_wait(); });
  test::require_eventually(test::kPatience, "three jobs to run", [&] { return pool.running() == 3; });
  pool.submit(kBatch, 0, [&](int threads) {
    last = threads;
    all_running.arrive_and_wait();
  });
  all_running.arrive_and_wait();
  pool.wait_idle();
  EXPECT_EQ(last, 1);
}

TEST(WorkerPool, AJobKnowsWhoseTurnItTakes) {
  WorkerPool pool(1, 100);
  std::string name;
  pool.submit(kBatch, 0, [&](int) { name = WorkerPool::flow().name; }, {.name = "alice"});
  pool.wait_idle();
  EXPECT_EQ(name, "alice");
  EXPECT_EQ(WorkerPool::flow().name, "") << "this thread runs no job";
}

TEST(WorkerPool, ItIsFullWhenAsManyWaitAsMay) {
  BusyPool busy(2);
  busy.add(kBatch, 'a');
  EXPECT_FALSE(busy.pool.full(kBatch));
  busy.add(kRealtime, 'b');
  EXPECT_TRUE(busy.pool.full(kBatch));
  busy.release();
  EXPECT_FALSE(busy.pool.full(kBatch));
}

TEST(WorkerPool, AQueueOfNoneStillFeedsIdleThreads) {
  std::latch release(1);
  WorkerPool pool(1, 0);
  EXPECT_FALSE(pool.full(kBatch));
  pool.submit(kBatch, 0, [&](int) { release.wait(); });
  test::require_eventually(test::kPatience, "a job to run", [&] { return pool.running() > 0; });
  EXPECT_TRUE(pool.full(kBatch));
  release.count_down();
}

TEST(WorkerPool, RealtimeGoesBeforeBatchAndResumedWorkBeforeBoth) {
  BusyPool busy;
  busy.add(kBatch, 'b');
  busy.add(kRealtime, 'r');
  busy.add(kBatch, 'c');
  busy.add(kRealtime, 's');
  busy.pool.resume([&](int) { busy.order += '!'; });
  busy.release();
  EXPECT_EQ(busy.order, "!rsbc");
}

TEST(WorkerPool, ResumedWorkAndQueuedWorkTakeTurns) {
  BusyPool busy;
  busy.add(kBatch, 'b');
  busy.add(kBatch, 'c');
  for (const char letter : {'1', '2', '3', '4'})
    busy.pool.resume([&busy, letter](int) { busy.order += letter; }, kBatch, 1.0);
  EXPECT_GE(busy.pool.predicted_wait(kBatch).count(), 4.0);
  busy.release();
  EXPECT_EQ(busy.order, "1b2c34");
}

TEST(WorkerPool, BatchWorkAges) {
  BusyPool busy;
  busy.add(kBatch, 'b');
  // pause: the pool reads the machine's clock, and the job must become old by it
  std::this_thread::sleep_for(WorkerPool::kAging + std::chrono::milliseconds(100));
  busy.add(kRealtime, 'r');
  busy.add(kBatch, 'c');
  busy.release();
  EXPECT_EQ(busy.order, "brc");
}

TEST(WorkerPool, APromotedTaskGoesWithTheRealtimeOnesByItsArrival) {
  BusyPool busy;
  busy.add(kBatch, 'b');
  const auto promoted = busy.add(kBatch, 'p');
  busy.add(kRealtime, 'r');
  busy.pool.reclassify(promoted, kRealtime);
  busy.pool.reclassify(promoted, kRealtime);
  busy.release();
  EXPECT_EQ(busy.order, "prb");
  busy.pool.reclassify(promoted, kRealtime);  // It ended long ago.
}

TEST(WorkerPool, ThePredictedWaitIsWhatGoesBeforeOverTheMeasuredThroughput) {
  BusyPool busy(100, 0);
  for (int i = 0; i < 500; ++i) busy.pool.measured("", 1, 2);  // twice as long as expected
  EXPECT_NEAR(busy.pool.predicted_run("", 3).count(), 6, 1e-6);
  EXPECT_EQ(busy.pool.predicted_wait(kBatch).count(), 0);
  busy.pool.submit(kBatch, 10, [](int) {});
  busy.pool.submit(kRealtime, 1, [](int) {});
  EXPECT_NEAR(busy.pool.predicted_wait(kRealtime).count(), 2, 1e-6);
  EXPECT_NEAR(busy.pool.predicted_wait(kBatch).count(), 22, 1e-6);
}

TEST(WorkerPool, TheBacklogIsAllOfTheClassAndOfMoreUrgentOnes) {
  BusyPool busy(100, 0);
  for (int i = 0; i < 500; ++i)
    for (const char* name : {"a", "b", "c"}) busy.pool.measured(name, 1, 2);
  for (const char* name : {"a", "b"})
    for (const Priority priority : {kRealtime, kBatch, Priority::kBackground})
      busy.pool.submit(priority, 10, [](int) {}, {name, 1});
  EXPECT_NEAR(busy.pool.backlog(kRealtime).count(), 40, 1e-6);
  EXPECT_NEAR(busy.pool.backlog(kBatch).count(), 80, 1e-6);
  EXPECT_NEAR(busy.pool.backlog(Priority::kBackground).count(), 120, 1e-6);
  EXPECT_NEAR(busy.pool.predicted_wait(kRealtime, {"c", 1}, 1).count(), 2 * 2, 1e-6)
      << "while it is computed, as much of both";
}

TEST(Pace, KnowsABoundedNumberOfClientsAndForgetsTheOneThatWasMeasuredLongestAgo) {
  Pace pace;
  pace.measured("first", 1, 50);
  pace.measured("second", 1, 50);
  pace.measured("first", 1, 50);
  const double first = pace.of("first");
  for (std::size_t k = 2; k <= Pace::kMostClients; ++k) pace.measured("client " + std::to_string(k), 1, 1);
  EXPECT_EQ(pace.known(), Pace::kMostClients);
  EXPECT_EQ(pace.of("first"), first);
  EXPECT_NEAR(pace.of("second"), 1, 1e-6) << "forgotten: as a newcomer";
}

TEST(Pace, ANewcomerHasTheLowerMedianOfTheKnownOnesAndTheStartValue) {
  Pace pace;
  const auto learn = [&pace](const char* name, double ratio) {
    for (int k = 0; k < 500; ++k) pace.measured(name, 1, ratio);
  };
  EXPECT_EQ(pace.of("new"), Pace::kStart);
  learn("a", 8);
  EXPECT_NEAR(pace.of("new"), 1, 1e-6) << "the lower one of two";
  learn("b", 4);
  EXPECT_NEAR(pace.of("new"), 4, 1e-6);
  learn("c", 1e6);
  EXPECT_NEAR(pace.of("new"), 4, 1e-6);
}

/// The work of one client takes ten thousand times the admission's estimate.
TEST(WorkerPool, OneClientsBadEstimatesAreNotTheOthersPredictions) {
  BusyPool busy(100, 0);
  busy.pool.submit(kBatch, 10, [](int) {}, {"known", 1});
  for (int i = 0; i < 500; ++i) {
    busy.pool.measured("known", 1, 2);
    busy.pool.measured("poisoner", 1, 10'000);
  }
  EXPECT_NEAR(busy.pool.predicted_run("known", 3).count(), 6, 1e-6);
  EXPECT_NEAR(busy.pool.predicted_wait(kBatch, {"known", 1}, 0).count(), 20, 1e-6);
  EXPECT_NEAR(busy.pool.predicted_run("newcomer", 3).count(), 6, 1e-6);
  EXPECT_NEAR(busy.pool.predicted_run("poisoner", 3).count(), 30'000, 1e-3) << "its own";
}

TEST(WorkerPool, NothingIsPredictedToWaitWhileAThreadIsIdle) {
  std::latch gate(1);  // outlives the pool, whose threads wait at it
  WorkerPool pool(2, 100);
  pool.submit(kBatch, 1000, [&](int) { gate.wait(); });
  test::require_eventually(test::kPatience, "a job to run", [&] { return pool.running() > 0; });
  EXPECT_EQ(pool.predicted_wait(kBatch).count(), 0);
  pool.submit(kBatch, 1000, [&](int) { gate.wait(); });
  EXPECT_GT(pool.predicted_wait(kBatch).count(), 100) << "both are busy, for long";
  gate.count_down();
}

TEST(WorkerPool, WhenNothingIsLeftToDoNobodysDebtIsRemembered) {
  std::latch gate(1);  // outlives the pool, whose threads wait at it
  WorkerPool pool(1, 100);
  std::string order;
  pool.submit(kBatch, 0, [](int) { WorkerPool::turn()->spent_elsewhere(1000); }, {"a", 1});
  pool.wait_idle();
  pool.submit(kBatch, 0, [&](int) { gate.wait(); }, {"gate", 1});
  pool.submit(kBatch, 1, [&](int) { order += 'a'; }, {"a", 1});
  pool.submit(kBatch, 1, [&](int) { order += 'b'; }, {"b", 1});
  gate.count_down();
  pool.wait_idle();
  EXPECT_EQ(order, "ab") << "in the order of arrival";
}

TEST(WorkerPool, WhoIsAwayLeavesItsProcessorHoweverUrgentItIs) {
  std::latch gate(1);
  WorkerPool pool(1, 100);
  std::atomic<bool> away{false}, batch{false};
  pool.submit(kRealtime, 0, [&](int) {
    const Away elsewhere(WorkerPool::turn());
    away = true;
    gate.wait();
  });
  EXPECT_TRUE(test::eventually(test::kPatience, "it to be away", [&] { return away.load(); }));
  pool.submit(kBatch, 0, [&](int) { batch = true; });
  EXPECT_TRUE(test::eventually(test::kPatience, "the batch job", [&] { return batch.load(); }));
  gate.count_down();
  pool.wait_idle();
}

TEST(WorkerPool, CoresAreAtLeastOne) { EXPECT_GE(available_cores(), 1); }

}  // namespace
}  // namespace fracture
