// A client that holds more than its even part of the working memory gives it up for a client that holds less. So does a
// client whose computations stand still. Computations that were given up begin again.
#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "server/service/memory_holders.hpp"
#include "tests/server/service/dispatcher_fixture.hpp"

namespace fracture::test {
namespace {

using Budget = MemoryBudget;

TEST(EvenPart, IsWhatAClientMayHoldWhateverOthersHold) {
  Budget whole(Budget::Divided{.capacity = 1000, .headroom = 0, .largest_small = 10, .even_parts = true},
               {.large = 750, .small = 750});
  const auto ana = std::make_shared<Budget::Client>(), bob = std::make_shared<Budget::Client>();
  Budget::Reservation held(whole, ana), mine(whole, bob), second(whole, bob);
  ASSERT_TRUE(held.grow_to(600));
  EXPECT_EQ(whole.even_part(*ana), 500u);
  EXPECT_EQ(whole.even_part(*bob), 500u);
  EXPECT_EQ(whole.judge(bob.get(), 400), Budget::Verdict::kFits);
  EXPECT_EQ(whole.judge(bob.get(), 450), Budget::Verdict::kHeldOverPart);
  EXPECT_EQ(whole.judge(bob.get(), 501), Budget::Verdict::kFull) << "more than the half";
  EXPECT_EQ(whole.judge(bob.get(), 450, Budget::Use::kBackground), Budget::Verdict::kFull);
  EXPECT_FALSE(mine.grow_to(400, Budget::Limit::kFairShare));
  EXPECT_FALSE(mine.grow_to(340, Budget::Limit::kEvenPart)) << "a third client waits";
  ASSERT_TRUE(mine.grow_to(333, Budget::Limit::kEvenPart));
  EXPECT_FALSE(second.grow_to(20, Budget::Limit::kOnlyOne));
  EXPECT_TRUE(second.grow_to(20));
  held = {};
  mine = {};
  second = {};
  EXPECT_EQ(whole.used(), 0u);
}

/// Ten clients that hold a little do not keep a large computation out of the free memory. Memory that cannot be given up stays
/// within FairShare.
TEST(EvenPart, IsNoLimitForAClientsOnlyReservationOfFreeMemory) {
  Budget whole(Budget::Divided{.capacity = 1000, .headroom = 0, .largest_small = 10, .even_parts = true},
               {.large = 750, .small = 750});
  std::vector<Budget::Reservation> little;
  for (int k = 0; k < 10; ++k) {
    little.emplace_back(whole, std::make_shared<Budget::Client>());
    ASSERT_TRUE(little.back().grow_to(30));
  }
  const auto ana = std::make_shared<Budget::Client>();
  Budget::Reservation kept(whole, ana), large(whole, ana), second(whole, ana);
  EXPECT_FALSE(kept.grow_to(400));
  large.may_take_all_free();
  EXPECT_FALSE(large.grow_to(701)) << "700 are free";
  EXPECT_TRUE(large.grow_to(400));
  Budget::Reservation moved = std::move(large);
  EXPECT_TRUE(moved.grow_to(600)) << "a running computation needs more";
  second.may_take_all_free();
  EXPECT_FALSE(second.grow_to(50)) << "not its only one";
}

struct LineOfParts : testing::Test {
  ClientShares memory{Budget::Divided{100, 0, 0, true}, 75};
  std::vector<std::string> asked, went_on;  // clients
  MemoryLine line{memory, [this](const std::string& client, std::uint64_t) { asked.push_back(client); }};
  std::vector<Budget::Reservation> held;

  bool take(const std::string& client, std::uint64_t bytes, bool again = false, bool stood_still = false) {
    std::optional<Budget::Reservation> got = line.take({.client = client,
                                                        .bytes = bytes,
                                                        .use = [] { return Budget::Use::kWaitedFor; },
                                                        .given_up = [] { return false; },
                                                        .go_on =
                                                            [this, client](Budget::Reservation later) {
                                                              went_on.push_back(client);
                                                              held.push_back(std::move(later));
                                                            },
                                                        .again = again,
                                                        .stood_still = stood_still});
    if (!got) return false;
    held.push_back(std::move(*got));
    return true;
  }
  void give_back() {
    held.pop_back();
    line.given_back();
  }
};

TEST_F(LineOfParts, GivesNobodyMoreThanItsPartWhileAnotherClientLacksItsOwn) {
  ASSERT_TRUE(take("ana", 40));
  ASSERT_TRUE(take("ana", 30));
  EXPECT_FALSE(take("bob", 35));
  EXPECT_EQ(asked, std::vector<std::string>{"bob"});
  EXPECT_FALSE(take("ana", 5)) << "although 30 are free";
  give_back();
  EXPECT_EQ(went_on, std::vector<std::string>{"bob"});
  line.given_back();
  EXPECT_EQ(went_on.back(), "ana") << "45 of 100";
  EXPECT_EQ(line.size(), 0u);
}

TEST_F(LineOfParts, GivesWorkThatWasGivenUpItsMemoryWhenItsClientHoldsNothingElse) {
  ASSERT_TRUE(take("bob", 10));
  ASSERT_TRUE(take("ana", 30));
  EXPECT_FALSE(take("ana", 30, /*again=*/true)) << "60 exceed its part";
  EXPECT_TRUE(asked.empty()) << "only its own client's work is in its way";
  EXPECT_TRUE(take("ana", 10)) << "new work may begin";
  give_back();
  EXPECT_TRUE(went_on.empty());
  give_back();
  EXPECT_EQ(went_on, std::vector<std::string>{"ana"});
}

TEST_F(LineOfParts, GivesWorkThatWasGivenUpItsPartAlthoughAnotherClientWaits) {
  ASSERT_TRUE(take("bob", 40));
  ASSERT_TRUE(take("zoe", 40));
  ASSERT_FALSE(take("bob", 30));
  EXPECT_FALSE(take("ana", 15, /*again=*/true, /*stood_still=*/true)) << "it may stand still again";
  EXPECT_TRUE(take("ana", 15, /*again=*/true)) << "its part is a third of 100";
}

TEST_F(LineOfParts, LetsNoNewWorkOfAClientOvertakeItsWorkThatWasGivenUp) {
  ASSERT_TRUE(take("ana", 30));
  ASSERT_TRUE(take("ana", 30));
  EXPECT_FALSE(take("ana", 25, /*again=*/true)) << "85 exceed its part, which is a half";
  give_back();
  EXPECT_FALSE(take("ana", 30)) << "60 exceed its part";
  give_back();
  ASSERT_EQ(held.size(), 2u);
  EXPECT_EQ(held[0].bytes(), 25u) << "the work that was given up goes first";
  EXPECT_EQ(held[1].bytes(), 30u);
}

TEST_F(LineOfParts, NeverWaitsAsAWholeWhileAllMemoryIsFree) {
  ASSERT_TRUE(take("ana", 90));
  for (const bool again : {true, false})
    for (const char* const client : {"ana", "bob"}) EXPECT_FALSE(take(client, 60, again));
  give_back();
  EXPECT_EQ(went_on, std::vector<std::string>{"ana"});
  give_back();
  EXPECT_EQ(went_on, (std::vector<std::string>{"ana", "bob"}));
  give_back();
  give_back();
  EXPECT_EQ(line.size(), 0u);
}

TEST(MemoryHoldersTest, SparesWorkThatWasGivenUpBefore) {
  MemoryHolders holders;
  std::string ended;
  const auto add = [&](const std::string& name, int begun_again) {
    return holders.add({.client = "ana",
                        .bytes = [] { return std::uint64_t{30}; },
                        .may_give_up = [](MemoryHolders::Why) { return true; },
                        .give_up = [&ended, name](MemoryHolders::Why) { ended += name; },
                        .begun_again = begun_again});
  };
  const auto first = add("1", 0), second = add("2", 0), third = add("3", 1);
  const auto held_by = [](const std::string&) { return std::uint64_t{90}; };
  EXPECT_TRUE(holders.give_up_over_part("bob", 30, 50, held_by));
  EXPECT_EQ(ended, "2") << "the latest of those that were not given up before";
  EXPECT_TRUE(holders.give_up_over_part("bob", 60, 50, held_by));
  EXPECT_EQ(ended, "21");
  for (const auto& holder : {first, second, third}) holders.remove(holder);
}

TEST(MemoryHoldersTest, EndsLessUrgentWorkFirstAndSparesWhatHasJustBegun) {
  MemoryHolders holders;
  std::string ended;
  const auto add = [&](const std::string& name, int urgency) {
    return holders.add({.client = "ana",
                        .bytes = [] { return std::uint64_t{30}; },
                        .may_give_up = [](MemoryHolders::Why) { return true; },
                        .give_up = [&ended, name](MemoryHolders::Why) { ended += name; },
                        .urgency = [urgency] { return urgency; }});
  };
  const auto batch = add("batch ", 1), realtime = add("realtime ", 0);
  const auto held_by = [](const std::string&) { return std::uint64_t{90}; };
  EXPECT_FALSE(holders.give_up_over_part("bob", 30, 50, held_by, std::chrono::hours(1)));
  EXPECT_EQ(ended, "");
  EXPECT_TRUE(holders.give_up_over_part("bob", 30, 50, held_by));
  EXPECT_EQ(ended, "batch ");
  EXPECT_TRUE(holders.give_up_over_part("bob", 60, 50, held_by));
  EXPECT_EQ(ended, "batch realtime ");
  for (const auto& holder : {batch, realtime}) holders.remove(holder);
}

/// Computations of ana hold memory and poll at a gate. Those of other clients are answered at once.
struct HeldOverPart : DispatcherTest {
  static constexpr std::uint64_t kMiB = 1u << 20;
  std::map<std::string, int> cuts;                         // by client
  std::map<std::uint64_t, std::optional<ErrorCode>> ends;  // by seed; nothing means an answer
  std::uint64_t last_seed = 0;
  WorkerPool wide{4, 256};
  Dispatcher small{service, wide, {64 * kMiB}};  // 56 MiB for all but small computations
  Gate gate;

  HeldOverPart() {
    control->during_cut = [this, hold = gate.hook()](const Execution& execution) {
      const std::string client = WorkerPool::flow().name;
      {
        const std::lock_guard lock(mutex);
        ++cuts[client];
      }
      if (client == "ana") hold(execution);
    };
  }
  static Terms of(const std::string& client, Priority priority = Priority::kBatch) {
    Terms terms;
    terms.priority = priority;
    terms.payer.flow = {client, 1};
    return terms;
  }
  /// 1000 sites take about 20 MiB, 1100 take 22, and 2200 take 38. Returns the seed.
  std::uint64_t ask_for(std::uint32_t sites, const Terms& terms, std::string mesh = {}) {
    const std::uint64_t seed = ++last_seed;
    if (mesh.empty())
      mesh = "mesh " + std::to_string(seed);  // the estimate would depend on a mesh that is known
    FractureRequest request = fracture_request(mesh, seed);
    request.parameters.fracture.sites = sites;
    const auto refused =
        small.fracture(std::move(request), terms, [this, seed](Expected<FractureAnswer> answer) {
          const std::lock_guard lock(mutex);
          ends[seed] = answer ? std::nullopt : std::optional(answer.error().code);
        });
    EXPECT_FALSE(refused) << refused->detail;
    return seed;
  }
  bool has_ended(std::uint64_t seed) {
    const std::lock_guard lock(mutex);
    return ends.contains(seed);
  }
  std::optional<ErrorCode> end_of(std::uint64_t seed) {
    test::require_eventually(test::kPatience, "the answer", [&] { return has_ended(seed); });
    const std::lock_guard lock(mutex);
    return ends.at(seed);
  }
  int cuts_of(const std::string& client) {
    const std::lock_guard lock(mutex);
    return cuts[client];
  }
  void end() {
    gate.open = true;
    small.wait_idle();
    EXPECT_EQ(small.figures().working_bytes, 0u);
    EXPECT_EQ(small.waiting_for_memory(), 0u);
  }
};

struct HeldOverPartFrom : HeldOverPart, testing::WithParamInterface<Priority> {};

TEST_P(HeldOverPartFrom, IsGivenUpForAClientThatHoldsLessAndBeginsAgain) {
  const std::uint64_t first = ask_for(1100, of("ana"));
  gate.wait_for(1);
  const std::uint64_t second = ask_for(1100, of("ana"));
  gate.wait_for(2);
  EXPECT_EQ(end_of(ask_for(1000, of("bob", GetParam()))), std::nullopt);
  EXPECT_FALSE(has_ended(first));
  EXPECT_FALSE(has_ended(second));
  test::require_eventually(test::kPatience, "the second to wait for the first one's memory",
                           [this] { return small.waiting_for_memory() == 1; });
  EXPECT_EQ(end_of(ask_for(1000, of("bob", GetParam()))), std::nullopt) << "the rest is still free";
  EXPECT_EQ(cuts_of("ana"), 2);
  gate.open = true;
  EXPECT_EQ(end_of(first), std::nullopt);
  EXPECT_EQ(end_of(second), std::nullopt);
  EXPECT_EQ(cuts_of("ana"), 3);
  end();
}

/// Nobody waits for a part that ends, and nothing is lost: the computations wait for a mesh that another client stores.
TEST_P(HeldOverPartFrom, IsGivenUpByComputationsThatWaitForWhatAnotherClientComputes) {
  Gate reads;
  std::atomic<int> imports{0};
  control->during_import = [&](const Execution& execution) {
    if (imports++ == 0) reads.pass(execution);
  };
  gate.open = true;
  std::atomic<bool> stored{false};
  EXPECT_FALSE(
      small.prepare(fracture_request("slow"), of("zoe"), [&](auto mesh) { stored = mesh.has_value(); }));
  reads.wait_for(1);
  const std::uint64_t first = ask_for(1100, of("ana"), "slow"), second = ask_for(1100, of("ana"), "slow");
  test::require_eventually(test::kPatience, "both to hold their memory",
                           [this] { return small.figures().working_bytes > 40 * kMiB; });
  EXPECT_EQ(end_of(ask_for(1000, of("bob", GetParam()))), std::nullopt);
  EXPECT_FALSE(has_ended(first));
  EXPECT_FALSE(has_ended(second));
  reads.open = true;
  EXPECT_EQ(end_of(first), std::nullopt);
  EXPECT_EQ(end_of(second), std::nullopt);
  EXPECT_EQ(cuts_of("ana"), 2) << "it was given up before it computed anything";
  end();
  EXPECT_TRUE(stored);
}

INSTANTIATE_TEST_SUITE_P(Classes, HeldOverPartFrom, testing::Values(Priority::kRealtime, Priority::kBatch),
                         [](const auto& instance) {
                           return instance.param == Priority::kRealtime ? std::string("Realtime")
                                                                        : std::string("Batch");
                         });

/// A single computation of more than half of the memory, while another client keeps asking.
TEST_F(HeldOverPart, BeginsAgainThreeTimesAndThenItsClientGetsTheError) {
  const std::uint64_t large = ask_for(2200, of("ana"));
  for (int attempt = 1; attempt <= 4; ++attempt) {
    gate.wait_for(attempt);
    EXPECT_FALSE(has_ended(large));
    EXPECT_EQ(end_of(ask_for(1100, of("bob"))), std::nullopt);
  }
  EXPECT_EQ(end_of(large), ErrorCode::kOverloaded);
  EXPECT_EQ(cuts_of("ana"), 4);
  end();
}

TEST_F(HeldOverPart, IsKeptUpToThePart) {
  const std::uint64_t first = ask_for(1100, of("ana"));
  gate.wait_for(1);
  const std::uint64_t large = ask_for(2200, of("bob"));
  test::require_eventually(test::kPatience, "bob to wait",
                           [this] { return small.waiting_for_memory() == 1; });
  gate.open = true;
  EXPECT_EQ(end_of(first), std::nullopt);
  EXPECT_EQ(end_of(large), std::nullopt);
  EXPECT_EQ(cuts_of("ana"), 1);
  end();
}

/// As for the compression of an answer, which can be sent as it is.
TEST_F(HeldOverPart, IsKeptIfTheOtherWorkMayNotWaitForMemory) {
  ask_for(1100, of("ana"));
  gate.wait_for(1);
  ask_for(1100, of("ana"));
  gate.wait_for(2);
  Terms terms = of("bob");
  terms.may_wait_for_memory = false;
  std::atomic<bool> ran{false};
  const auto refused = small.run(
      {0.001, 20 * kMiB}, terms, [&](const Execution&) { ran = true; }, [](const Error&) {});
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, ErrorCode::kOverloaded);
  EXPECT_EQ(small.waiting_for_memory(), 0u);
  end();
  EXPECT_FALSE(ran);
  EXPECT_EQ(cuts_of("ana"), 2);
}

TEST_F(HeldOverPart, IsGivenUpWithinThePartByAComputationThatStandsStill) {
  tenants::Shares shares;
  shares.cores = 1;
  const auto account =
      std::make_shared<tenants::Account>(tenants::Tenant{"ana", {}, {}, shares}, /*isolated=*/true);
  Terms slow = of("ana");
  slow.payer.account = account;
  const std::uint64_t first = ask_for(1100, slow);
  gate.wait_for(1);
  account->charge(1000);
  for (const Priority priority : {Priority::kRealtime, Priority::kBatch})
    EXPECT_EQ(end_of(ask_for(2200, of("bob", priority))), std::nullopt);
  EXPECT_FALSE(has_ended(first));
  account->configure(tenants::Tenant{"ana", {}, {}, {}}, /*isolated=*/true);
  gate.open = true;
  EXPECT_EQ(end_of(first), std::nullopt);
  EXPECT_EQ(cuts_of("ana"), 2);
  end();
}

}  // namespace
}  // namespace fracture::test
