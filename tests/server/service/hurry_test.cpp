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

/// The places of a class are for those who began there.
TEST_F(Demoted, WhoWasHurriedDoesNotEndWhoBeganInTheClass) {
  pool.reclassify(first.id, kRealtime);
  pool.reclassify(second.id, kRealtime);
  second.wait();
  pool.reclassify(second.id, kBackground);
  pool.reclassify(first.id, kBackground);
  EXPECT_TRUE(eventually(kPatience, "the second to end", [&] { return second.was_ended.load(); }));
  EXPECT_FALSE(first.was_ended);
}

/// Jobs that batch requests have joined, and stay.
TEST_F(Demoted, HoweverManyAreBatchWorkACollisionIsServed) {
  pool.reclassify(first.id, kBatch);
  hurry_until_it_runs(second, kRealtime);
  pool.reclassify(second.id, kBatch);
  std::deque<Polling> tasks;
  for (int k = 0; k < 3; ++k) hurry_until_it_runs(tasks.emplace_back(pool, 1, kBackground), kRealtime);
  const Computing collision(pool, 1, kRealtime);
  EXPECT_FALSE(first.was_ended);
}

/// A pool in which nobody waits for long.
struct LongHurry : testing::Test {
  WorkerPool pool{1, 100, {std::chrono::milliseconds(50), std::chrono::milliseconds(50)}};
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

TEST_F(LongHurry, OfBatchWorkEndsToo) {
  Computing joined(pool, 1, kBackground);
  pool.reclassify(joined.id, kBatch);
  const Computing batch(pool, 1, kBatch);
  EXPECT_FALSE(joined.was_ended);
}

/// Of files, which are read in other processes: those who wait for them do not stand still.
TEST_F(DispatcherTest, AnImportThatIsHurriedForEverHoldsUpNobody) {
  Gate gate;
  std::atomic<int> imports{0};
  control->during_import = [&](const Execution& execution) {
    if (imports++ < 2) gate.pass(execution);
  };
  Terms hurried;
  hurried.priority = Priority::kRealtime;
  for (const char* mesh : {"long", "longer"}) {
    ask(fracture_request(mesh));
    ask(fracture_request(mesh), hurried);
  }
  gate.wait_for(2);
  ask(fracture_request("collision"), hurried);
  EXPECT_TRUE(eventually(kPatience, "the collision's answer", [&] { return good == 1; }));
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 5);
}

TEST_F(DispatcherTest, AnImportThatWasHurriedAndIsOneTooManyEnds) {
  Gate gate;
  control->during_import = gate.hook();
  Terms background, hurried;
  background.priority = Priority::kBackground;
  std::stop_source gone;
  hurried.priority = Priority::kRealtime;
  hurried.gone = gone.get_token();
  for (const char* mesh : {"one", "two", "three"}) ask(fracture_request(mesh), background);
  ask(fracture_request("three"), hurried);
  gate.wait_for(3);
  gone.request_stop();
  EXPECT_TRUE(eventually(kPatience, "the third to end", [&] { return bad == 2; }));
  EXPECT_EQ(errors[ErrorCode::kOverloaded], 1);
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 2);
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
