// Errands, which are work without a flight (such as a body to decode or an entry to read): their deadline,
// the departure of their client, and their place.
#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stop_token>

#include "server/service/dispatcher.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/fracture_request.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

constexpr ExpectedWork kWork{0.001, 1000};

struct Errands : testing::Test {
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  FractureService service{ServiceConfig{}, std::make_unique<FakeEngine>(control)};
  WorkerPool pool{1, 256};
  Dispatcher dispatcher{service, pool};
  std::latch gate{1};
  std::atomic<int> ran{0}, given_up{0};
  std::atomic<ErrorCode> why{ErrorCode::kInternal};
  std::string words;  ///< the detail of the last error

  void occupy() {
    pool.submit(Priority::kBatch, 0, [this](int) { gate.wait(); });
    ASSERT_TRUE(eventually(kPatience, "the thread to be taken", [&] { return pool.running() == 1; }));
  }
  std::optional<Error> run(const Terms& terms) {
    return dispatcher.run(
        kWork, terms, [this](const Execution&) { ++ran; },
        [this](const Error& error) {
          why = error.code;
          words = error.detail;
          ++given_up;
        });
  }
  /// Needs 20 MiB of the dispatcher's memory, and does not wait for it.
  std::optional<Error> run_without_waiting(Dispatcher& small) {
    Terms terms;
    terms.payer.flow = {"bob", 1};
    terms.may_wait_for_memory = false;
    return small.run(
        {0.001, 20u << 20}, terms, [this](const Execution&) { ++ran; },
        [this](const Error& error) {
          why = error.code;
          ++given_up;
        });
  }
  static Terms of(const std::string& name, std::uint64_t computations) {
    tenants::Shares shares;
    shares.computations = computations;
    Terms terms;
    terms.payer.account =
        std::make_shared<tenants::Account>(tenants::Tenant{name, {}, {}, shares}, /*isolated=*/true);
    terms.payer.flow = {name, 1};
    return terms;
  }
};

TEST_F(Errands, OneWhoseDeadlinePassesInTheQueueIsGivenUpThereAndHoldsNothing) {
  occupy();
  Terms terms;
  // The running job is said to cost nothing, so no wait is predicted.
  terms.deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(20);
  ASSERT_FALSE(run(terms));
  EXPECT_TRUE(eventually(kPatience, "the end of its wait", [&] { return given_up == 1; }));
  EXPECT_EQ(why.load(), ErrorCode::kDeadlineExceeded);
  EXPECT_EQ(words.find("sites"), std::string::npos)
      << "not everything that is asked for has sites: " << words;
  EXPECT_NE(words.find("Request-Timeout"), std::string::npos) << words;
  EXPECT_EQ(pool.queued(), 0u);
  EXPECT_EQ(dispatcher.working().used(), 0u);
  EXPECT_EQ(dispatcher.figures().expired, 1u);
  gate.count_down();
  dispatcher.wait_idle();
  EXPECT_EQ(ran, 0);
}

TEST_F(Errands, OneWhoseClientLeavesIsTakenOutOfTheQueue) {
  occupy();
  std::stop_source gone;
  Terms terms;
  terms.gone = gone.get_token();
  ASSERT_FALSE(run(terms));
  ASSERT_FALSE(run({}));
  EXPECT_EQ(pool.queued(), 2u);
  gone.request_stop();
  EXPECT_EQ(given_up, 1);
  EXPECT_EQ(why.load(), ErrorCode::kCancelled);
  EXPECT_EQ(pool.queued(), 1u);
  EXPECT_EQ(dispatcher.working().used(), 0u) << "what is queued holds nothing";
  ASSERT_FALSE(run(terms)) << "who has left before it came";
  EXPECT_EQ(given_up, 2);
  gate.count_down();
  dispatcher.wait_idle();
  EXPECT_EQ(ran, 1) << "the other one's";
}

TEST_F(Errands, OneThatContinuesAdmittedWorkIsAlsoTakenOutOfTheQueue) {
  occupy();
  std::stop_source gone;
  Terms terms;
  terms.gone = gone.get_token();
  terms.is_computed = true;
  ASSERT_FALSE(run(terms));
  EXPECT_EQ(pool.queued(), 1u);
  gone.request_stop();
  EXPECT_EQ(given_up, 1);
  EXPECT_EQ(pool.queued(), 0u);
  gate.count_down();
  dispatcher.wait_idle();
  EXPECT_EQ(ran, 0);
}

TEST_F(Errands, OneThatMayNotWaitForMemoryIsGivenUpWhenItsTurnComes) {
  Dispatcher small(service, pool, {.max_working_bytes = 64u << 20});  // 56 MiB for large reservations
  occupy();
  ASSERT_FALSE(run_without_waiting(small));
  MemoryBudget::Reservation taken(small.working());
  ASSERT_TRUE(taken.grow_to(50u << 20));
  EXPECT_TRUE(run_without_waiting(small)) << "there is too little now";
  gate.count_down();
  small.wait_idle();
  EXPECT_EQ(small.waiting_for_memory(), 0u);
  EXPECT_EQ(ran, 0);
  EXPECT_EQ(given_up, 1);
  EXPECT_EQ(why.load(), ErrorCode::kOverloaded);
  taken = {};
  EXPECT_FALSE(run_without_waiting(small));
  small.wait_idle();
  EXPECT_EQ(ran, 1);
  EXPECT_EQ(small.working().used(), 0u);
}

TEST_F(Errands, WhatRunsIsToldOfDeadlineAndLeaving) {
  std::stop_source gone;
  Terms terms;
  terms.gone = gone.get_token();
  terms.deadline = std::chrono::steady_clock::now() + std::chrono::hours(1);
  std::atomic<bool> interrupted{false}, begun{false};
  ASSERT_FALSE(dispatcher.run(
      kWork, terms,
      [&](const Execution& execution) {
        EXPECT_EQ(execution.deadline, terms.deadline);
        EXPECT_NE(execution.turn, nullptr) << "batch work stands back at its polls";
        begun = true;
        try {
          for (;;) execution.poll();
        } catch (const Interrupted&) {
          interrupted = true;
        }
      },
      [](const Error&) { FAIL(); }));
  ASSERT_TRUE(eventually(kPatience, "it to begin", [&] { return begun.load(); }));
  gone.request_stop();
  dispatcher.wait_idle();
  EXPECT_TRUE(interrupted);
}

TEST_F(Errands, TakesAPlaceAmongTheComputationsOfItsName) {
  occupy();
  const Terms terms = of("ana", 1);
  ASSERT_FALSE(run(terms));
  const auto over = run(terms);
  ASSERT_TRUE(over);
  EXPECT_EQ(over->code, ErrorCode::kOverShare);
  EXPECT_FALSE(run(of("bob", 1))) << "the others are not concerned";
  Terms finishing = terms;
  finishing.needs_seat = false;
  EXPECT_FALSE(run(finishing));
  gate.count_down();
  dispatcher.wait_idle();
  EXPECT_EQ(terms.payer.account->figures().computations, 0u);
  EXPECT_FALSE(run(terms)) << "its place is free again";
  dispatcher.wait_idle();
}

TEST_F(Errands, HandsItsPlaceOnToTheNextStepOfTheRequest) {
  Terms terms = of("ana", 1);
  terms.seat = std::make_shared<tenants::Account::Seat>();
  std::atomic<int> answered{0};
  const auto fracture = [&](const Execution&) {
    EXPECT_EQ(terms.payer.account->figures().computations, 1u);
    const auto over = dispatcher.fracture(fracture_request("mesh"), terms,
                                          [&](const auto& answer) { answered += answer.has_value(); });
    EXPECT_FALSE(over) << over->detail;
    EXPECT_EQ(terms.payer.account->figures().computations, 1u) << "the same place";
  };
  ASSERT_FALSE(dispatcher.run(kWork, terms, fracture, [](const Error&) { FAIL(); }));
  dispatcher.wait_idle();
  EXPECT_EQ(answered, 1);
  EXPECT_EQ(terms.payer.account->figures().computations, 0u);
}

}  // namespace
}  // namespace fracture::test
