// Equal requests are computed once, and the computation ends when the last client that waits for it has left.
#include <chrono>
#include <future>
#include <latch>
#include <stop_token>
#include <thread>
#include <vector>

#include "tests/server/service/dispatcher_fixture.hpp"

namespace fracture::test {
namespace {

using std::chrono::steady_clock;

TEST_F(DispatcherTest, SixtyFourIdenticalColdRequestsAreOneComputation) {
  Gate gate;
  control->during_cut = gate.hook();
  for (int i = 0; i < 64; ++i) ask(fracture_request("mesh"));
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 64);
  EXPECT_EQ(control->imports, 1);
  EXPECT_EQ(control->diagrams, 1);
  EXPECT_EQ(control->cuts, 1);
  EXPECT_EQ(outcomes[CacheOutcome::kMissStored], 1);
  EXPECT_EQ(outcomes[CacheOutcome::kCollapsed], 63);
  EXPECT_EQ(dispatcher.figures().collapsed, 63u);
  ask(fracture_request("mesh"));
  EXPECT_EQ(outcomes[CacheOutcome::kHit], 1) << "answered at once, on this thread";
}

TEST_F(DispatcherTest, TheLeaderIsCancelledHalfWayAndTheOthersSucceed) {
  Gate gate;
  control->during_cut = gate.hook();
  std::stop_source leader;
  Terms terms;
  terms.gone = leader.get_token();
  ask(fracture_request("mesh"), terms);
  for (int i = 0; i < 63; ++i) ask(fracture_request("mesh"));
  gate.wait_for(1);
  leader.request_stop();
  EXPECT_EQ(errors[ErrorCode::kCancelled], 1) << "told at once";
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 63);
  EXPECT_EQ(control->cuts, 1);
  EXPECT_EQ(control->cancelled, 0);
}

TEST_F(DispatcherTest, TheComputationDiesWithTheLastWhoWaits) {
  Gate gate;
  control->during_cut = gate.hook();
  std::stop_source everybody;
  Terms terms;
  terms.gone = everybody.get_token();
  for (int i = 0; i < 5; ++i) ask(fracture_request("mesh"), terms);
  gate.wait_for(1);
  everybody.request_stop();
  dispatcher.wait_idle();  // would hang if the computation went on, because the gate is closed
  EXPECT_EQ(control->cancelled, 1);
  EXPECT_EQ(errors[ErrorCode::kCancelled], 5);
  EXPECT_EQ(dispatcher.figures().flights, 0u);
}

TEST_F(DispatcherTest, ManySeedsOfOneColdMeshPrepareItOnce) {
  Gate gate;
  control->import = [&](std::string_view) -> Expected<Mesh> {
    gate.pass({});
    return Mesh{};
  };
  for (int seed = 0; seed < 20; ++seed) ask(fracture_request("mesh", static_cast<std::uint64_t>(seed)));
  gate.wait_for(1);
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 20);
  EXPECT_EQ(control->imports, 1);
  EXPECT_EQ(control->prepares, 1);
  EXPECT_EQ(control->cuts, 20);
}

TEST_F(DispatcherTest, WaitingForAMeshHoldsNoThread) {
  Gate gate;
  control->import = [&](std::string_view mesh) -> Expected<Mesh> {
    if (mesh == "slow") gate.pass({});
    return Mesh{};
  };
  for (int seed = 0; seed < 20; ++seed) ask(fracture_request("slow", static_cast<std::uint64_t>(seed)));
  gate.wait_for(1);
  std::promise<void> done;  // One thread imports for all twenty requests; the other thread is free.
  EXPECT_FALSE(dispatcher.fracture(fracture_request("quick"), {}, [&](Expected<FractureAnswer> answer) {
    EXPECT_TRUE(answer);
    done.set_value();
  }));
  EXPECT_EQ(done.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
  EXPECT_EQ(good, 0);
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 20);
}

TEST_F(DispatcherTest, WhoLeavesWhileWaitingForAMeshDoesNotStopItForTheOthers) {
  Gate gate;
  control->import = [&](std::string_view) -> Expected<Mesh> {
    gate.pass({});
    return Mesh{};
  };
  std::stop_source first, third;
  for (int seed = 0; seed < 4; ++seed) {
    Terms terms;
    if (seed == 0) terms.gone = first.get_token();
    if (seed == 2) terms.gone = third.get_token();
    ask(fracture_request("mesh", static_cast<std::uint64_t>(seed)), terms);
    if (seed == 0) gate.wait_for(1);  // the first request does the import
  }
  test::require_eventually(test::kPatience, "the queue to be empty", [&] { return pool.queued() == 0; });
  first.request_stop();
  third.request_stop();
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 2);
  EXPECT_EQ(errors[ErrorCode::kCancelled], 2);
  EXPECT_EQ(control->imports, 1);
  EXPECT_EQ(control->cuts, 2);
}

TEST_F(DispatcherTest, AnotherDualWaitsForTheSameTetrahedralization) {
  for (const Dual dual : {Dual::kCircumcenter, Dual::kBarycenter}) {
    FractureRequest r = fracture_request("mesh");
    r.parameters.fracture.dual = dual;
    ask(std::move(r));
  }
  dispatcher.wait_idle();
  EXPECT_EQ(good, 2);
  EXPECT_EQ(control->diagrams, 1);
  EXPECT_EQ(control->cuts, 2);
}

TEST_F(DispatcherTest, EachWaiterHasItsOwnDeadline) {
  Gate gate;
  control->during_cut = gate.hook();
  Terms hasty;
  hasty.deadline = steady_clock::now() + std::chrono::milliseconds(50);
  ask(fracture_request("mesh"), hasty);
  ask(fracture_request("mesh"));
  test::require_eventually(test::kPatience, "the first refusal", [&] { return bad > 0; });
  EXPECT_EQ(errors[ErrorCode::kDeadlineExceeded], 1);
  EXPECT_EQ(good, 0);
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 1);
  EXPECT_EQ(control->cuts, 1);
}

TEST_F(DispatcherTest, WorkWhoseDeadlinePassedInTheQueueIsNotDone) {
  Gate gate;
  control->during_cut = gate.hook();
  ask(fracture_request("a"));
  ask(fracture_request("b"));
  gate.wait_for(2);  // both threads are busy
  Terms terms;
  terms.deadline = steady_clock::now() + std::chrono::milliseconds(500);
  ask(fracture_request("late"), terms);
  test::require_eventually(test::kPatience, "the first refusal", [&] { return bad > 0; });
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 2);
  EXPECT_EQ(errors[ErrorCode::kDeadlineExceeded], 1);
  EXPECT_EQ(control->imports, 2) << "nothing of the late one was begun";
}

// The first prediction for a client can be far too high. A short wait must not make it a refusal.
TEST_F(DispatcherTest, WorkThatWaitedIsTriedIfItsPredictionWouldNeverHaveFitted) {
  Gate gate;
  control->during_cut = gate.hook();
  ask(fracture_request("a"));
  ask(fracture_request("b"));
  gate.wait_for(2);  // both threads are busy
  Terms terms;
  terms.deadline = steady_clock::now() + std::chrono::seconds(60);
  ask(fracture_request("c"), terms);
  for (int i = 0; i < 200; ++i) pool.measured("", 1, 1e7);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // pause: so that the request has waited
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 3);
  EXPECT_EQ(bad, 0);
}

TEST_F(DispatcherTest, WhatCannotBeInTimeIsRefusedAtOnceWithTheTimeToComeBack) {
  Gate gate;
  control->during_cut = gate.hook();
  for (int i = 0; i < 200; ++i) pool.measured("", 1, 1000);  // a machine a thousand times slower than nominal
  ask(fracture_request("a"));
  ask(fracture_request("b"));
  gate.wait_for(2);
  Terms terms;
  terms.deadline = steady_clock::now() + std::chrono::seconds(1);
  const auto overload =
      dispatcher.fracture(fracture_request("c"), terms, [](Expected<FractureAnswer>) { FAIL(); });
  ASSERT_TRUE(overload);
  EXPECT_GE(overload->retry_after.count(), 1);
  EXPECT_LE(overload->retry_after.count(), 60);
  EXPECT_EQ(dispatcher.figures().refused, 1u);
  ask(fracture_request("a"), terms);  // a request that only waits for work in flight costs nothing
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 3);
}

TEST_F(DispatcherTest, AnErrorIsEverybodysAndNobodyKeepsIt) {
  Gate gate;
  control->import = [&](std::string_view) -> Expected<Mesh> {
    gate.pass({});
    return fail(ErrorCode::kMalformedMesh, "broken");
  };
  for (int i = 0; i < 3; ++i) ask(fracture_request("mesh", static_cast<std::uint64_t>(i)));
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(errors[ErrorCode::kMalformedMesh], 3);
  control->import = nullptr;
  ask(fracture_request("mesh"));
  dispatcher.wait_idle();
  EXPECT_EQ(good, 1);
}

TEST_F(DispatcherTest, ABrokenInvariantIsAnInternalErrorForAllAndTheNextOneWorks) {
  control->during_cut = [](const Execution&) { throw InternalError("an invariant"); };
  ask(fracture_request("mesh"));
  dispatcher.wait_idle();
  control->during_cut = [](const Execution&) { throw std::bad_alloc(); };
  ask(fracture_request("mesh"));
  dispatcher.wait_idle();
  EXPECT_EQ(errors[ErrorCode::kInternal], 1);
  EXPECT_EQ(errors[ErrorCode::kOutOfMemory], 1);
  control->during_cut = nullptr;
  ask(fracture_request("mesh"));
  dispatcher.wait_idle();
  EXPECT_EQ(good, 1);
}

TEST_F(DispatcherTest, PreparingIsSharedWithTheFractureThatNeedsIt) {
  Gate gate;
  control->import = [&](std::string_view) -> Expected<Mesh> {
    gate.pass({});
    return Mesh{};
  };
  std::atomic<int> prepared{0};
  EXPECT_FALSE(
      dispatcher.prepare(fracture_request("mesh"), {}, [&](auto mesh) { prepared += mesh.has_value(); }));
  gate.wait_for(1);
  ask(fracture_request("mesh"));
  EXPECT_FALSE(
      dispatcher.prepare(fracture_request("mesh"), {}, [&](auto mesh) { prepared += mesh.has_value(); }));
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(prepared, 2);
  EXPECT_EQ(good, 1);
  EXPECT_EQ(control->imports, 1);
}

TEST_F(DispatcherTest, EveryoneIsToldOfTheProgress) {
  std::mutex guard;
  std::map<int, std::vector<std::string>> stages;
  Gate gate;
  control->import = [&](std::string_view) -> Expected<Mesh> {
    gate.pass({});
    return Mesh{};
  };
  for (int who = 0; who < 2; ++who) {
    Terms terms;
    terms.progress = [&, who](Stage stage, double) {
      const std::lock_guard lock(guard);
      stages[who].emplace_back(name_of(stage));
    };
    ask(fracture_request("mesh"), terms);
    gate.wait_for(1);
  }
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(stages[0], (std::vector<std::string>{"import", "prepare", "tetrahedralize", "clip", "encode"}));
  EXPECT_EQ(stages[1], (std::vector<std::string>{"prepare", "tetrahedralize", "clip", "encode"}));
}

TEST_F(DispatcherTest, ComingAndGoingAtRandomNobodyIsForgotten) {
  std::atomic<int> replies{0};
  constexpr int kThreads = 4, kRounds = 300;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < kRounds; ++i) {
        std::stop_source gone;
        Terms terms;
        terms.gone = gone.get_token();
        terms.priority = i % 2 ? Priority::kRealtime : Priority::kBatch;
        if (i % 5 == 0) terms.deadline = steady_clock::now() + std::chrono::microseconds(50 * (i % 7));
        const auto overload = dispatcher.fracture(fracture_request("mesh" + std::to_string(i / 40), i % 13),
                                                  terms, [&](const Expected<FractureAnswer>&) { ++replies; });
        if (overload) ++replies;
        if ((i + t) % 3 == 0) gone.request_stop();
      }
    });
  for (std::thread& thread : threads) thread.join();
  dispatcher.wait_idle();
  EXPECT_EQ(replies, kThreads * kRounds);
  EXPECT_EQ(dispatcher.figures().flights, 0u);
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
}

// An answer that fails its certificate is remembered, so equal requests get the error without another
// computation.
TEST_F(DispatcherTest, AnAnswerThatDoesNotProveItselfIsNotComputedAgainAndAgain) {
  control->cut_error = [] {
    return Error{ErrorCode::kUnsound, "3 edges are open", {}, Figures(nlohmann::json{{"open_edges", 3}})};
  };
  for (int round = 0; round < 5; ++round) {
    ask(fracture_request("mesh"));
    dispatcher.wait_idle();
  }
  EXPECT_EQ(errors[ErrorCode::kUnsound], 5);
  EXPECT_EQ(control->cuts, 1);
  EXPECT_EQ(service.figures().unsound, 1u);
  EXPECT_EQ(service.figures().results.entries, 0u);

  control->cut_error = nullptr;
  ask(fracture_request("mesh", 2));
  dispatcher.wait_idle();
  EXPECT_EQ(good, 1) << "another request is another answer";
}

TEST(FailureMemo, ForgetsTheOldest) {
  FailureMemo memo;
  for (std::size_t k = 0; k <= FailureMemo::kMost; ++k)
    memo.add(std::to_string(k), Error{ErrorCode::kUnsound, std::to_string(k)});
  EXPECT_FALSE(memo.find("0"));
  EXPECT_EQ(memo.find("1")->detail, "1");
  EXPECT_EQ(memo.count(), FailureMemo::kMost + 1);
}

}  // namespace
}  // namespace fracture::test
