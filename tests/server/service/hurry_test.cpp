// A client that hurries shared work, or leaves it, keeps no thread from later clients.
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <functional>
#include <stop_token>

#include "tests/server/service/dispatcher_fixture.hpp"
#include "tests/server/service/polling.hpp"

namespace fracture::test {
namespace {

/// One background task that computes, and one that was hurried until it ran.
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

/// The places of a class belong to tasks that began in it.
TEST_F(Demoted, WhoWasHurriedDoesNotEndWhoBeganInTheClass) {
  pool.reclassify(first.id, kRealtime);
  pool.reclassify(second.id, kRealtime);
  second.wait();
  pool.reclassify(second.id, kBackground);
  pool.reclassify(first.id, kBackground);
  EXPECT_TRUE(eventually(kPatience, "the second to end", [&] { return second.was_ended.load(); }));
  EXPECT_FALSE(first.was_ended);
}

/// A task that began in a class does not keep its place there after it became less urgent.
TEST_F(Demoted, ATaskThatBecameBackgroundLeavesBatchWorkItsPlace) {
  first.end = second.end = true;
  pool.wait_idle();
  const Computing posted(pool, 1, kBatch);
  pool.reclassify(posted.id, kBackground);
  const Computing batch(pool, 1, kBatch);
  EXPECT_FALSE(posted.was_ended);
}

/// A hurried job that resumes after waiting for a part, and is then no longer hurried, keeps the place of its original class.
TEST_F(Demoted, AResumedHurriedJobKeepsThePlaceOfItsClass) {
  first.end = second.end = true;
  pool.wait_idle();
  std::atomic<bool> end{false}, ended{false};
  std::atomic<long> polls{0};
  const auto id = pool.resume(
      [&](int) {
        try {
          for (; !end; ++polls) WorkerPool::turn()->give_way();
        } catch (const Interrupted&) {
          ended = true;
        }
      },
      kRealtime, 0, kBackground);
  require_eventually(kPatience, "it to run", [&] { return polls > 0; });
  Polling other(pool, 1, kBackground);
  pool.reclassify(id, kBackground);
  const long before = polls;
  EXPECT_TRUE(eventually(kPatience, "it to compute", [&] { return polls > before + 1000; }));
  EXPECT_EQ(other.polls, 0) << "there is one place";
  end = true;
  other.wait();
  other.end = true;
  pool.wait_idle();
  EXPECT_FALSE(ended);
}

/// Batch requests have joined the jobs, and stay.
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
  // Two clients in turn: one of them always waits.
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

/// As many computations as there are threads stay at a station, and collisions that never leave wait for
/// them.
struct HurriedForEver : DispatcherTest {
  Gate gate;
  std::atomic<int> came{0};

  void others_are_answered(std::function<void(const Execution&)> FakeControl::*station) {
    (*control).*station = [&](const Execution& execution) {
      if (came++ < 2) gate.pass(execution);
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
};

TEST_F(HurriedForEver, ACutHoldsUpNobody) { others_are_answered(&FakeControl::during_cut); }

/// The import runs in another process. A computation that waits for it does not pause.
TEST_F(HurriedForEver, AnImportHoldsUpNobody) { others_are_answered(&FakeControl::during_import); }

/// As many jobs as may run read their files. A collision waits for one more job, until the collision leaves.
struct OneTooMany : DispatcherTest {
  Gate gate;
  Terms background, hurried;
  std::stop_source gone;

  void SetUp() override {
    control->during_import = gate.hook();
    background.priority = Priority::kBackground;
    hurried.priority = Priority::kRealtime;
    hurried.gone = gone.get_token();
    for (const char* mesh : {"one", "two"}) ask(fracture_request(mesh), background);
    gate.wait_for(2);
  }
  void TearDown() override {
    gate.open = true;
    dispatcher.wait_idle();
  }
};

TEST_F(OneTooMany, EndsWhileItReadsItsFile) {
  ask(fracture_request("three"), background);
  ask(fracture_request("three"), hurried);
  gate.wait_for(3);
  gone.request_stop();
  EXPECT_TRUE(eventually(kPatience, "the third to end", [&] { return bad == 2; }));
  EXPECT_EQ(errors[ErrorCode::kOverloaded], 1);
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 2);
}

/// If the leader is ended because it was hurried, others that wait for its mesh go on.
TEST_F(OneTooMany, DoesNotEndWhoWaitsForItsMesh) {
  ask(fracture_request("three"), hurried);
  gate.wait_for(3);
  ask(fracture_request("three"), background);  // the same answer
  ask(fracture_request("three", 2), hurried);  // another answer for the same mesh
  ask(fracture_request("three", 2), background);
  require_eventually(kPatience, "it to wait for the mesh",
                     [&] { return pool.queued() == 0 && pool.running() == 3; });
  gone.request_stop();
  EXPECT_TRUE(eventually(kPatience, "the third to end", [&] { return bad == 3; }));
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(errors[ErrorCode::kOverloaded], 1) << "who led";
  EXPECT_EQ(good, 3);
}

TEST_F(DispatcherTest, WhatNobodyWaitsForLeavesTheQueueAtOnce) {
  Gate gate;
  control->during_cut = gate.hook_without_polls();
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
  EXPECT_EQ(dispatcher.working().used(), before) << "queued work holds no memory";
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
