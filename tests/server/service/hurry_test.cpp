// Who hurries others' work, or leaves it, keeps no thread from those who come after.
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <stop_token>

#include "tests/server/service/dispatcher_fixture.hpp"
#include "tests/server/service/polling.hpp"

namespace fracture::test {
namespace {

/// One of background, and one that was hurried until it ran.
struct Demoted : testing::Test {
  WorkerPool pool{1, 100};
  Computing first{pool, 1, kBackground};
  Polling second{pool, 1, kBackground};

  void TearDown() override { first.end = second.end = true; }
  void hurry_until_it_runs(Polling& task, Priority priority) {
    pool.reclassify(task.id, priority);
    task.wait();
    pool.reclassify(task.id, kBackground);
  }
};

TEST_F(Demoted, ATaskThatFindsItsClassFullEndsAndTheOthersGoOn) {
  hurry_until_it_runs(second, kBatch);
  EXPECT_TRUE(eventually(kPatience, "the second to end", [&] { return second.was_ended.load(); }));
  EXPECT_EQ(second.ended_by.load(), ErrorCode::kOverloaded);
  const Computing batch(pool, 1, kBatch);
  EXPECT_FALSE(first.done);
}

TEST_F(Demoted, HoweverManyWereHurriedACollisionIsServed) {
  std::deque<Polling> tasks;
  for (int k = 0; k < 6; ++k) hurry_until_it_runs(tasks.emplace_back(pool, 1, kBackground), kRealtime);
  const Computing batch(pool, 1, kBatch), collision(pool, 1, kRealtime);
}

TEST_F(Demoted, OneThatFindsRoomGoesOn) {
  first.end = true;
  second.wait();
  Polling third(pool, 1, kBatch);
  third.wait();
  pool.reclassify(third.id, kRealtime);
  pool.reclassify(third.id, kBatch);
  const long before = third.polls;
  EXPECT_TRUE(eventually(kPatience, "it to compute", [&] { return third.polls > before + 100; }));
  EXPECT_FALSE(third.was_ended);
}

/// A pool in which a hurry is short.
struct LongHurry : testing::Test {
  WorkerPool pool{1, 100, std::chrono::milliseconds(50)};
};

TEST_F(LongHurry, EndsWhereAnotherCollisionWaits) {
  Computing hurried(pool, 1, kRealtime);
  const Computing collision(pool, 1, kRealtime);
  EXPECT_FALSE(hurried.done);
  EXPECT_FALSE(hurried.was_ended) << "it stands still as batch work does";
}

TEST_F(LongHurry, IsNotBegunAnewByWhoeverComesNext) {
  Computing hurried(pool, 1, kBackground);
  // Two clients by turns: one of them always waits.
  const auto hurry = [&] {
    pool.reclassify(hurried.id, kBackground);
    pool.reclassify(hurried.id, kRealtime);
  };
  hurry();
  std::atomic<bool> stop{false};
  std::jthread relay([&] {
    while (!stop) {
      hurry();
      std::this_thread::yield();
    }
  });
  { const Computing collision(pool, 1, kRealtime); }
  stop = true;
  EXPECT_FALSE(hurried.was_ended);
}

TEST_F(DispatcherTest, AJobThatIsHurriedForEverHoldsUpNobody) {
  Gate gate;
  std::atomic<int> cuts{0};
  control->during_cut = [&](const Execution& execution) {
    if (cuts++ < 2) gate.pass(execution);
  };
  Terms hurried;
  hurried.priority = Priority::kRealtime;
  for (const char* mesh : {"long", "longer"}) {
    ask(fracture_request(mesh));
    ask(fracture_request(mesh), hurried);  // who never leaves
  }
  gate.wait_for(2);
  ask(fracture_request("collision"), hurried);
  EXPECT_TRUE(eventually(kPatience, "the collision's answer", [&] { return good == 1; }));
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 5);
}

TEST_F(DispatcherTest, WhatNobodyWaitsForLeavesTheQueueAtOnce) {
  Gate gate;
  control->during_cut = [&](const Execution&) { gate.pass_without_polls(); };
  for (const char* mesh : {"one", "two"}) ask(fracture_request(mesh));
  gate.wait_for(2);
  const std::uint64_t before = dispatcher.working().used();
  std::stop_source gone;
  Terms terms;
  terms.priority = Priority::kBackground;
  terms.gone = gone.get_token();
  ask(fracture_request("three"), terms);
  ask(fracture_request("three"), terms);
  EXPECT_EQ(pool.queued(), 1u);
  EXPECT_GT(dispatcher.working().used(), before);
  gone.request_stop();
  EXPECT_EQ(pool.queued(), 0u);
  EXPECT_EQ(dispatcher.working().used(), before);
  EXPECT_EQ(bad, 2);
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 2);
}

}  // namespace
}  // namespace fracture::test
