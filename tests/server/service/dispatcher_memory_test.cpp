// Computations begin when there is memory for them, and their reservation covers what they make.
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

  // Each of the two would fit alone. While one holds its memory, the other is refused.
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

/// Two computations of one client. The second one finds that it needs more memory than the first one leaves
/// to that client.
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

/// A job of ana holds memory and polls at a gate; bob waits for an answer that needs some of the memory.
struct HeldInBackground : DispatcherTest {
  static constexpr std::uint64_t kMiB = 1u << 20;
  Dispatcher small{service, pool, {64 * kMiB}};  // an eighth is for small computations
  Gate gate;
  std::map<std::string, std::optional<ErrorCode>> ends;  // by client; nothing means an answer

  std::atomic<std::uint64_t> makes{0};  ///< bytes that the next computation makes beyond its estimate
  std::atomic<int> cuts{0};

  HeldInBackground() {
    control->during_cut = [this](const Execution& execution) {
      const bool first = cuts++ == 0;
      execution.made(Product::kImportBytes, makes);
      if (first) gate.pass(execution);
    };
  }
  void ask_as(const std::string& client, Priority priority, std::uint64_t bytes, std::uint32_t sites = 10) {
    makes = bytes;
    FractureRequest request = fracture_request("mesh of " + client, 1);
    request.parameters.fracture.sites = sites;
    Terms terms;
    terms.priority = priority;
    terms.payer.flow = {client, 1};
    const auto refused =
        small.fracture(std::move(request), terms, [this, client](Expected<FractureAnswer> answer) {
          const std::lock_guard lock(mutex);
          ends[client] = answer ? std::nullopt : std::optional(answer.error().code);
        });
    EXPECT_FALSE(refused) << refused->detail;
  }
  void begin_job(std::uint64_t bytes) {
    ask_as("ana", Priority::kBackground, bytes);
    gate.wait_for(1);
  }
  std::optional<ErrorCode> end_of(const std::string& client) {
    test::require_eventually(test::kPatience, "the answer of " + client, [&] {
      const std::lock_guard lock(mutex);
      return ends.contains(client);
    });
    const std::lock_guard lock(mutex);
    return ends.at(client);
  }
  void end() {
    gate.open = true;
    small.wait_idle();
    EXPECT_EQ(small.figures().working_bytes, 0u);
  }
};

TEST_F(HeldInBackground, IsGivenUpWhenAComputationThatSomebodyWaitsForGrows) {
  begin_job(40 * kMiB);
  ask_as("bob", Priority::kBatch, 22 * kMiB);
  EXPECT_EQ(end_of("bob"), std::nullopt);
  EXPECT_EQ(end_of("ana"), ErrorCode::kOverloaded) << "as a job, it begins again";
  end();
}

TEST_F(HeldInBackground, IsGivenUpWhenTheTurnComesOfAComputationThatIsExpectedToNeedIt) {
  begin_job(40 * kMiB);
  ask_as("bob", Priority::kBatch, 0, 1100);
  EXPECT_EQ(end_of("bob"), std::nullopt);
  EXPECT_EQ(end_of("ana"), ErrorCode::kOverloaded);
  end();
}

/// The further jobs began to wait before bob did. The first job's memory is enough for both of them, but not
/// for bob as well.
TEST_F(HeldInBackground, IsNotTakenByFurtherJobsThatWaitForMemory) {
  Gate grows, busy;
  control->during_cut = [&](const Execution& execution) {
    if (execution.turn->is_urgent()) return;  // bob's computation
    if (cuts++ == 0) {
      grows.pass(execution);
      execution.made(Product::kImportBytes, 40 * kMiB);
    }
    gate.pass(execution);
  };
  ask_as("ana", Priority::kBackground, 0);
  grows.wait_for(1);
  pool.submit(Priority::kBackground, 0, [&](int) { busy.pass_without_polls(); }, {"ana", 1});
  busy.wait_for(1);
  for (const std::uint32_t sites : {1100u, 1101u}) ask_as("ana", Priority::kBackground, 0, sites);
  grows.open = true;
  gate.wait_for(1);
  busy.open = true;
  test::require_eventually(test::kPatience, "both jobs to wait for memory",
                           [this] { return small.waiting_for_memory() == 2; });
  ask_as("bob", Priority::kRealtime, 0, 1100);
  EXPECT_EQ(end_of("bob"), std::nullopt);
  end();
}

/// Bob uploads the mesh. Ana's job waits for it and holds memory meanwhile.
TEST_F(HeldInBackground, IsGivenUpByAJobThatWaitsForWhatAnotherClientComputes) {
  Gate reads;
  std::atomic<int> imports{0};
  control->during_cut = nullptr;
  control->during_import = [&](const Execution& execution) {
    if (imports++ == 0) reads.pass(execution);
  };
  Terms terms;
  terms.payer.flow = {"bob", 1};
  std::atomic<bool> stored{false};
  EXPECT_FALSE(
      small.prepare(fracture_request("mesh of ana"), terms, [&](auto mesh) { stored = mesh.has_value(); }));
  reads.wait_for(1);
  ask_as("ana", Priority::kBackground, 0, 2200);  // 38 MiB
  test::require_eventually(test::kPatience, "the job to hold its memory",
                           [this] { return small.figures().working_bytes > 38 * kMiB; });
  ask_as("eve", Priority::kBatch, 0, 1000);  // 20 MiB
  EXPECT_EQ(end_of("eve"), std::nullopt);
  EXPECT_EQ(end_of("ana"), ErrorCode::kOverloaded) << "as a job, it begins again";
  reads.open = true;
  end();
  EXPECT_TRUE(stored) << "bob's upload goes on";
}

TEST_F(HeldInBackground, LeavesAThreadToOthersUntilItIsFree) {
  control->during_cut = [this](const Execution& execution) {
    const bool first = cuts++ == 0;
    execution.made(Product::kImportBytes, makes);
    if (first) gate.pass_without_polls();
  };
  begin_job(32 * kMiB);  // half as much more is reserved
  ask_as("bob", Priority::kBatch, 22 * kMiB);
  test::require_eventually(test::kPatience, "bob to need more", [this] { return cuts == 2; });
  ask_as("eve", Priority::kBatch, 0);
  EXPECT_EQ(end_of("eve"), std::nullopt);
  {
    const std::lock_guard lock(mutex);
    EXPECT_FALSE(ends.contains("bob")) << "he waited on both threads' time";
  }
  end();
}

TEST_F(HeldInBackground, IsKeptUpToTheHalf) {
  begin_job(28 * kMiB);
  ask_as("bob", Priority::kBatch, 32 * kMiB);
  EXPECT_EQ(end_of("bob"), ErrorCode::kOutOfMemory) << "more than the other half";
  end();
  EXPECT_EQ(end_of("ana"), std::nullopt);
}

TEST_F(HeldInBackground, IsKeptFromOtherBackgroundWork) {
  begin_job(40 * kMiB);
  ask_as("bob", Priority::kBackground, 22 * kMiB);
  EXPECT_EQ(end_of("bob"), ErrorCode::kOutOfMemory);
  end();
  EXPECT_EQ(end_of("ana"), std::nullopt);
}

struct MemoryLineTest : testing::Test {
  using Use = MemoryBudget::Use;
  ClientShares memory{MemoryBudget::Divided{100, 0, 0}, 100};
  std::vector<std::string> asked;  // clients for which memory was requested
  MemoryLine line{memory, [this](const std::string& client, std::uint64_t) { asked.push_back(client); }};
  std::vector<std::string> went_on;
  std::vector<MemoryBudget::Reservation> held;

  bool take(const std::string& client, const Use& use, std::uint64_t bytes) {
    std::optional<MemoryBudget::Reservation> got =
        line.take({client, bytes, [&use] { return use; }, [] { return false; },
                   [this, client](MemoryBudget::Reservation later) {
                     went_on.push_back(client);
                     held.push_back(std::move(later));
                   }});
    if (!got) return false;
    held.push_back(std::move(*got));
    return true;
  }
  void give_back(std::size_t k) {
    held.erase(held.begin() + static_cast<std::ptrdiff_t>(k));
    line.given_back();
  }
  const Use background = Use::kBackground, waited_for = Use::kWaitedFor;
};

TEST_F(MemoryLineTest, GivesBackgroundWorkNothingWhileSomebodyNeedsWhatItGivesUp) {
  {
    const MemoryLine::Claim claim(line);
    EXPECT_FALSE(take("ana", background, 10));
    EXPECT_TRUE(take("bob", waited_for, 10));
    line.given_back();
    EXPECT_TRUE(went_on.empty());
  }
  EXPECT_EQ(went_on, std::vector<std::string>{"ana"});
  EXPECT_EQ(line.size(), 0u);
}

/// The first job that gives up its memory frees enough for only one of the two clients.
TEST_F(MemoryLineTest, AsksForRoomAgainWhileSomebodyLacksIt) {
  for (int job = 0; job < 3; ++job) ASSERT_TRUE(take("ana", background, 30));
  EXPECT_FALSE(take("bob", waited_for, 35));
  EXPECT_FALSE(take("eve", waited_for, 12));
  asked.clear();
  give_back(0);
  EXPECT_EQ(went_on, std::vector<std::string>{"bob"});
  EXPECT_EQ(asked, std::vector<std::string>{"eve"}) << "60 of 100 are background work's";
  give_back(0);
  EXPECT_EQ(went_on.back(), "eve");
}

TEST_F(MemoryLineTest, AsksForRoomForWorkThatAClientBeginsToWaitFor) {
  Use use = Use::kBackground;
  ASSERT_TRUE(take("ana", background, 60));
  EXPECT_FALSE(take("bob", use, 45));
  EXPECT_TRUE(asked.empty()) << "background work makes no room";
  use = Use::kWaitedFor;
  line.given_back();
  EXPECT_EQ(asked, std::vector<std::string>{"bob"});
  give_back(0);
  EXPECT_EQ(went_on, std::vector<std::string>{"bob"});
  EXPECT_EQ(held.back().use(), Use::kWaitedFor);
}

}  // namespace
}  // namespace fracture::test
