// Exceptions in code that a thread of the pool, of the timer or of a flight calls: other work goes on.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>

#include "server/service/dispatcher.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

struct Stations : testing::Test {
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  FractureService service{ServiceConfig{}, std::make_unique<FakeEngine>(control)};
  WorkerPool pool{1, 256};
  Dispatcher dispatcher{service, pool};

  void ask(std::uint64_t seed, Dispatcher::FractureReply reply, const Terms& terms = {}) {
    FractureRequest request;
    const auto text = std::make_shared<const std::string>("mesh");
    request.mesh = std::as_bytes(std::span(*text));
    request.owner = text;
    request.parameters.fracture.seed = seed;
    EXPECT_FALSE(dispatcher.fracture(std::move(request), terms, std::move(reply)));
  }
};

TEST_F(Stations, AReplyThatThrowsCostsNobodyElseTheirAnswer) {
  std::atomic<bool> go{false};
  control->during_cut = [&](const Execution&) {
    require_eventually(kPatience, "the test to let the cut go on", [&] { return go.load(); });
  };
  std::atomic<int> answered{0};
  ask(1, [](Expected<FractureAnswer>) { throw std::runtime_error("a client that cannot be told"); });
  for (int k = 0; k < 3; ++k) ask(1, [&](Expected<FractureAnswer> answer) { answered += answer ? 1 : 0; });
  go = true;
  dispatcher.wait_idle();
  EXPECT_EQ(answered, 3) << "who waited for the same";
  ask(2, [&](Expected<FractureAnswer> answer) { answered += answer ? 1 : 0; });
  dispatcher.wait_idle();
  EXPECT_EQ(answered, 4) << "the thread goes on";
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
}

// A file may wait, together with others, for a process that reads it.
TEST_F(Stations, AnImportKnowsWhetherSomebodyIsInAHurry) {
  std::atomic<int> urgent{0}, others{0};
  control->during_import = [&](const Execution& execution) {
    ASSERT_TRUE(execution.turn);
    ++(execution.turn->is_urgent() ? urgent : others);
  };
  Terms terms;
  for (const Priority priority : {Priority::kRealtime, Priority::kBatch, Priority::kBackground}) {
    terms.priority = priority;
    FractureRequest request;
    const auto text =
        std::make_shared<const std::string>("mesh " + std::to_string(static_cast<int>(priority)));
    request.mesh = std::as_bytes(std::span(*text));
    request.owner = text;
    EXPECT_FALSE(dispatcher.fracture(std::move(request), terms, [](Expected<FractureAnswer> answer) {
      EXPECT_TRUE(answer) << answer.error().detail;
    }));
    dispatcher.wait_idle();
  }
  EXPECT_EQ(urgent, 1);
  EXPECT_EQ(others, 2);
}

TEST_F(Stations, AJobThatThrowsIsCountedAndTheNextOneRuns) {
  std::atomic<bool> ran{false};
  pool.submit(Priority::kBatch, 0.001, [](int) { throw std::runtime_error("a bug"); });
  pool.submit(Priority::kBatch, 0.001, [&](int) { ran = true; });
  pool.wait_idle();
  EXPECT_TRUE(ran);
  EXPECT_EQ(pool.escaped(), 1u);
}

TEST_F(Stations, ATimerCallThatThrowsDoesNotStopTheTimer) {
  std::atomic<bool> called{false};
  dispatcher.timer().at(Timer::Clock::now(), [] { throw std::runtime_error("a bug"); });
  dispatcher.timer().at(Timer::Clock::now(), [&] { called = true; });
  EXPECT_TRUE(eventually(kPatience, "the second call", [&] { return called.load(); }));
}

}  // namespace
}  // namespace fracture::test
