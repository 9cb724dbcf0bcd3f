// Computations begin when there is room for them, and hold what they make.
#include "tests/server/service/dispatcher_fixture.hpp"

namespace fracture::test {
namespace {

TEST_F(DispatcherTest, MemoryIsHandedOutByEstimateAndOneAloneAlwaysRuns) {
  Dispatcher narrow(service, pool, {.max_working_bytes = 1});
  Gate gate;
  control->during_cut = gate.hook();
  std::atomic<int> answers{0};
  const auto reply = [&](Expected<FractureAnswer> answer) { answers += answer.has_value(); };
  EXPECT_FALSE(narrow.fracture(fracture_request("a"), {}, reply));
  gate.wait_for(1);
  EXPECT_TRUE(narrow.fracture(fracture_request("b"), {}, reply));
  gate.open = true;
  narrow.wait_idle();
  EXPECT_FALSE(narrow.fracture(fracture_request("b"), {}, reply)) << "what was held is given back";
  narrow.wait_idle();
  EXPECT_EQ(answers, 2);
  EXPECT_EQ(narrow.figures().working_bytes, 0u);
}

TEST_F(DispatcherTest, AComputationHoldsWhatItMakesUntilItEnds) {
  Gate gate;
  constexpr std::uint64_t kPolygons = 100'000;
  control->during_cut = [&](const Execution& execution) {
    execution.made(Product::kPolygons, kPolygons);
    gate.pass(execution);
  };
  ask(fracture_request("mesh"));
  gate.wait_for(1);
  EXPECT_GE(dispatcher.figures().working_bytes, kPolygons * bytes_of(Product::kPolygons));
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(good, 1);
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
}

TEST_F(DispatcherTest, AComputationThatNeverFitsIsRefusedByNameAndOneThatOthersCrowdOutMayComeBack) {
  constexpr std::uint64_t kMemory = 64u << 20;
  Dispatcher small(service, pool, {kMemory});
  std::mutex of_outcomes;
  std::map<std::uint64_t, Expected<FractureAnswer>> outcomes_of;
  const auto run = [&](std::uint64_t seed) {
    const auto overload =
        small.fracture(fracture_request("mesh", seed), {}, [&, seed](Expected<FractureAnswer> answer) {
          const std::lock_guard lock(of_outcomes);
          outcomes_of.emplace(seed, std::move(answer));
        });
    EXPECT_FALSE(overload);
  };
  control->during_cut = [&](const Execution& execution) {
    for (int k = 0; k < 10'000; ++k) execution.made(Product::kCapTriangles, 1000);
  };
  run(1);
  small.wait_idle();
  ASSERT_FALSE(outcomes_of.at(1));
  EXPECT_EQ(outcomes_of.at(1).error().code, ErrorCode::kTooComplex);
  EXPECT_EQ(outcomes_of.at(1).error().extra->at("grew"), "cap_triangles");
  EXPECT_EQ(outcomes_of.at(1).error().extra->at("limit"), kMemory - kMemory / 8)
      << "the rest is for small ones";

  // Two that would each fit alone: while one holds its memory, the other is sent away.
  Gate gate;
  std::atomic<bool> first{true};
  control->during_cut = [&](const Execution& execution) {
    const bool stays = first.exchange(false);
    if (!stays) gate.wait_for(1);
    execution.made(Product::kCapTriangles, kMemory * 6 / 10 / bytes_of(Product::kCapTriangles));
    if (stays) gate.pass(execution);
  };
  run(2);
  run(3);
  const auto answered = [&](std::uint64_t seed) {
    const std::lock_guard lock(of_outcomes);
    return outcomes_of.contains(seed);
  };
  test::require_eventually(test::kPatience, "one of the two answers",
                           [&] { return answered(2) || answered(3); });
  gate.open = true;
  small.wait_idle();
  const bool two = outcomes_of.at(2).has_value(), three = outcomes_of.at(3).has_value();
  ASSERT_NE(two, three);
  EXPECT_EQ(outcomes_of.at(two ? 3 : 2).error().code, ErrorCode::kOutOfMemory);
  EXPECT_EQ(small.figures().working_bytes, 0u);
}

/// Two computations of one client; the second one finds that it needs more than the first one leaves to its client.
struct OwnHoldings : DispatcherTest {
  static constexpr std::uint64_t kMemory = 64u << 20;
  Dispatcher small{service, pool, {kMemory}};
  Gate holds, grows;
  std::atomic<int> cuts{0};
  std::map<std::string, std::vector<Expected<FractureAnswer>>> answers;  // by client

  OwnHoldings() {
    control->during_cut = [this](const Execution& execution) {
      const bool first = cuts++ == 0;
      if (!first) grows.pass(execution);
      execution.made(Product::kCapTriangles, kMemory * 6 / 10 / bytes_of(Product::kCapTriangles));
      if (first) holds.pass(execution);
    };
  }
  void ask_as(const std::string& client, std::uint64_t seed) {
    Terms terms;
    terms.payer.flow = {client, 1};
    EXPECT_FALSE(small.fracture(fracture_request("mesh", seed), terms,
                                [this, client](Expected<FractureAnswer> answer) {
                                  const std::lock_guard lock(mutex);
                                  answers[client].push_back(std::move(answer));
                                }));
  }
  void begin_both() {
    ask_as("ana", 1);
    holds.wait_for(1);
    ask_as("ana", 2);
    grows.wait_for(1);
  }
  Error error_of(const std::string& client) {
    test::require_eventually(test::kPatience, "the answer of " + client, [&] {
      const std::lock_guard lock(mutex);
      return !answers[client].empty();
    });
    const std::lock_guard lock(mutex);
    const Expected<FractureAnswer>& first = answers[client].front();
    return first ? Error{ErrorCode::kInternal, "it has an answer"} : first.error();
  }
};

TEST_F(OwnHoldings, AreAnsweredAsTheClientsShare) {
  begin_both();
  grows.open = true;
  const Error error = error_of("ana");
  EXPECT_EQ(error.code, ErrorCode::kOverShare) << error.detail;
  EXPECT_GT(error.retry_after.count(), 0);
  EXPECT_TRUE(error.extra->contains("bytes")) << "for a job that begins again";
  holds.open = true;
  small.wait_idle();
}

TEST_F(OwnHoldings, AreNoShareOfAnotherClientWhoWaitsForTheSame) {
  begin_both();
  ask_as("bob", 2);
  grows.open = true;
  const Error error = error_of("bob");
  EXPECT_EQ(error.code, ErrorCode::kOverloaded) << error.detail;
  EXPECT_GT(error.retry_after.count(), 0);
  holds.open = true;
  small.wait_idle();
}

}  // namespace
}  // namespace fracture::test
