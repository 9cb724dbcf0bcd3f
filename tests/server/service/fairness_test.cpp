// Processor time is shared between clients while it is used: which computation pauses for which, and how much
// time each gets.
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <latch>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "server/service/worker_pool.hpp"
#include "tests/server/service/polling.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

const Flow kA{"a"}, kB{"b"};

std::shared_ptr<tenants::Account> account_of(double cores) {
  tenants::Shares shares;
  shares.cores = cores;
  return std::make_shared<tenants::Account>(tenants::Tenant{"a", {}, {}, shares}, /*isolated=*/true);
}

/// Reports at each poll a millisecond of time used elsewhere. Its progress is counted in polls, so no clock
/// decides.
struct Using {
  Using(WorkerPool& pool, const Flow& flow, Priority priority = kBatch, double seconds = 0.001) {
    id = pool.submit(
        priority, 0,
        [this, seconds](int) {
          while (!end) {
            WorkerPool::turn()->spent_elsewhere(seconds);
            WorkerPool::charge_by_now();
            ++polls;
            WorkerPool::turn()->give_way();
            std::this_thread::yield();
          }
          done = true;
        },
        flow);
  }
  ~Using() {
    end = true;
    EXPECT_TRUE(eventually(kPatience, "it to end", [&] { return done.load(); }));
  }
  void wait_for(long more = 1) const {
    const long before = polls;
    EXPECT_TRUE(eventually(kPatience, "it to compute", [&] { return polls >= before + more; }));
  }
  WorkerPool::TaskId id = 0;
  std::atomic<bool> end{false}, done{false};
  std::atomic<long> polls{0};
};

TEST(Fairness, ALongComputationStandsStillForAnotherClientsOfItsClass) {
  WorkerPool pool(1, 100);
  Using first(pool, kA);
  first.wait_for();
  std::atomic<bool> answered{false};
  pool.submit(
      kBatch, 0, [&](int) { answered = true; }, kB);
  EXPECT_TRUE(eventually(kPatience, "the other's answer", [&] { return answered.load(); }));
  EXPECT_FALSE(first.done);
  first.wait_for();
}

TEST(Fairness, AsManyLongComputationsAsThereAreThreadsHoldUpNobodyElse) {
  for (const Priority priority : {kRealtime, kBatch, kBackground}) {
    WorkerPool pool(2, 100);
    Using one(pool, kA, priority), two(pool, kA, priority);
    one.wait_for();
    two.wait_for();
    for (const Priority other : {kRealtime, kBatch, kBackground}) {
      std::atomic<int> answered{0};
      for (int k = 0; k < 10; ++k)
        pool.submit(
            other, 0, [&](int) { ++answered; }, kB);
      EXPECT_TRUE(eventually(kPatience, "the answers", [&] { return answered == 10; }));
    }
    EXPECT_FALSE(one.done || two.done);
  }
}

TEST(Fairness, EachOfManyClientsWithLongComputationsGetsItsTurn) {
  WorkerPool pool(2, 100);
  std::deque<Using> clients;
  for (int k = 0; k < 6; ++k) clients.emplace_back(pool, Flow{std::to_string(k)});
  for (const Using& client : clients) client.wait_for(10);
  std::atomic<bool> answered{false};
  pool.submit(
      kBatch, 0, [&](int) { answered = true; }, kB);
  EXPECT_TRUE(eventually(kPatience, "who asks for little", [&] { return answered.load(); }));
}

TEST(Fairness, TwoClientsWithOneProcessorGetHalfOfItEach) {
  WorkerPool pool(1, 100);
  Using one(pool, kA, kBatch, 0.002), two(pool, kB, kBatch, 0.002);
  one.wait_for();
  two.wait_for();
  const long first = one.polls, second = two.polls;
  EXPECT_TRUE(eventually(kPatience, "both to go on",
                         [&] { return one.polls > first + 400 && two.polls > second + 400; }));
  const auto a = static_cast<double>(one.polls - first), b = static_cast<double>(two.polls - second);
  EXPECT_LT(a, 1.5 * b);
  EXPECT_LT(b, 1.5 * a);
}

TEST(Fairness, WhoUsesMuchAsRealtimeStandsStillForTheBatchWorkOfAnother) {
  WorkerPool pool(1, 100);
  Using flood(pool, kA, kRealtime, 0.01);
  flood.wait_for(200);
  std::atomic<bool> answered{false};
  pool.submit(
      kBatch, 0, [&](int) { answered = true; }, kB);
  EXPECT_TRUE(eventually(kPatience, "the batch answer", [&] { return answered.load(); }));
  EXPECT_FALSE(flood.done);
}

TEST(Fairness, WhatIsUsedIsChargedToTheAccountBeforeTheEnd) {
  WorkerPool pool(1, 100);
  const Flow flow{"a", 1, account_of(1000)};
  Using job(pool, flow, kBatch, 0.5);
  EXPECT_TRUE(
      eventually(kPatience, "the charge", [&] { return flow.account->figures().processor_seconds >= 5; }));
  EXPECT_FALSE(job.done);
}

TEST(Fairness, WhoIsOverItsProcessorRateStandsStillAndTheOthersDoNot) {
  WorkerPool pool(2, 100);
  const Flow flow{"a", 1, account_of(0.001)};
  Using over(pool, flow, kBatch, 100);  // more than it may use in a day
  EXPECT_TRUE(eventually(kPatience, "it to stand still", [&] { return pool.paused() == 1; }));
  const long before = over.polls;
  std::atomic<bool> own{false};
  const auto queued = pool.submit(
      kBatch, 0, [&](int) { own = true; }, flow);
  Using other(pool, kB);
  other.wait_for(200);
  EXPECT_EQ(over.polls, before);
  EXPECT_FALSE(own) << "nor does it begin anything";
  EXPECT_TRUE(pool.withdraw(queued));
  pool.share(over.id);
  EXPECT_TRUE(
      eventually(kPatience, "it to go on for who else waits for it", [&] { return over.polls > before; }));
}

TEST(Fairness, WhoIsWithinItsRateAgainGoesOn) {
  WorkerPool pool(1, 100);
  const Flow flow{"a", 1, account_of(10)};  // a hundred seconds at once
  std::atomic<int> done{0};
  for (int k = 0; k < 3; ++k)
    pool.submit(
        kBatch, 0,
        [&done, k](int) {
          WorkerPool::turn()->spent_elsewhere(k == 0 ? 101 : 0);
          ++done;
        },
        flow);
  pool.wait_idle();
  EXPECT_EQ(done, 3);
}

TEST(Fairness, WhoStandsStillEndsWhenItIsWantedNoMore) {
  WorkerPool pool(1, 100);
  const Flow flow{"a", 1, account_of(0.001)};
  std::stop_source gone;
  std::atomic<int> ended{0};
  const auto compute = [&](Execution execution) {
    pool.submit(
        kBatch, 0,
        [&ended, execution](int) mutable {
          execution.turn = WorkerPool::turn();
          WorkerPool::stands_still_while_wanted(execution);
          execution.turn->spent_elsewhere(100);
          WorkerPool::charge_by_now();
          try {
            for (;;) execution.poll();
          } catch (const Interrupted&) {
            ++ended;
          }
        },
        flow);
  };
  Execution stopped;
  stopped.stop = gone.get_token();
  compute(stopped);
  EXPECT_TRUE(eventually(kPatience, "it to stand still", [&] { return pool.paused() == 1; }));
  gone.request_stop();
  EXPECT_TRUE(eventually(kPatience, "it to end", [&] { return ended == 1; }));
}

TEST(Fairness, ThePoolEndsThoughWhoIsOverItsRateWaits) {
  std::atomic<int> done{0};
  {
    WorkerPool pool(1, 100);
    const Flow flow{"a", 1, account_of(0.001)};
    for (int k = 0; k < 2; ++k)
      pool.submit(
          kBatch, 0,
          [&](int) {
            WorkerPool::turn()->spent_elsewhere(1000);
            WorkerPool::charge_by_now();
            WorkerPool::turn()->give_way();
            ++done;
          },
          flow);
    EXPECT_TRUE(eventually(kPatience, "the first to stand still", [&] { return pool.paused() == 1; }));
  }
  EXPECT_EQ(done, 2);
}

}  // namespace
}  // namespace fracture::test
