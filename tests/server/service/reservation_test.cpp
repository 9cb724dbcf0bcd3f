// The share of memory that a computation reserves: an estimate from the known figures of its mesh, corrected
// when more figures are known.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <latch>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "tests/server/service/reservations.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

TEST_F(ReservationTest, AStoredMeshIsReservedForByItsTriangles) {
  std::atomic<std::uint64_t> held{0};
  control->during_cut = [&](const Execution&) { held = dispatcher.figures().working_bytes; };
  EXPECT_FALSE(ask(request(1'000'000)));
  EXPECT_GE(held, 220'000'000u);
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
}

TEST_F(ReservationTest, WhatTheFileDidNotSayIsReservedWhenItWasRead) {
  control->import = [](std::string_view) { return Expected<Mesh>(mesh_of(1'000'000)); };
  std::atomic<std::uint64_t> held{0};
  control->during_cut = [&](const Execution&) { held = dispatcher.figures().working_bytes; };
  EXPECT_FALSE(ask(request()));
  EXPECT_GE(held, 48'000'000u + 200'000'000u) << "its arrays, and what it takes to prepare them";
}

TEST_F(ReservationTest, WhatAReaderTookIsFreeWhenItHasEnded) {
  std::atomic<std::uint64_t> held{0}, at_import{0};
  control->during_import = [&](const Execution& execution) {
    const Allowance::Temporary reader(execution.allowance);
    execution.made(Product::kImportBytes, 500u << 20);
    at_import = dispatcher.figures().working_bytes;
  };
  control->during_cut = [&](const Execution&) { held = dispatcher.figures().working_bytes; };
  EXPECT_FALSE(ask(request()));
  EXPECT_GE(at_import, 500u << 20);
  EXPECT_LT(held, 16u << 20);
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
}

TEST_F(ReservationTest, OnesThatShrinkAreCountedInThePoolThatTheyAreIn) {
  MemoryBudget whole(1000, MemoryBudget::SmallPool{100, 10}, {.large = 500, .small = 50});
  const auto client = std::make_shared<MemoryBudget::Client>();
  {
    MemoryBudget::Reservation large(whole, client), small(whole, client);
    ASSERT_TRUE(large.grow_to(400));
    ASSERT_TRUE(small.grow_to(8));
    large.shrink_to(200);
    small.shrink_to(5);
    large.shrink_to(300);  // it already holds less
    EXPECT_EQ(large.bytes(), 200u);
    EXPECT_EQ(whole.used(), 205u);
    EXPECT_EQ(whole.small_used(), 5u);
    EXPECT_EQ(client->large, 200u);
    EXPECT_EQ(client->small, 5u);
    large.shrink_to(0);
    EXPECT_EQ(large.bytes(), 11u) << "a large one still";
    EXPECT_EQ(whole.small_used(), 5u);
    ASSERT_TRUE(large.grow_to(20));
  }
  EXPECT_EQ(whole.used(), 0u);
  EXPECT_EQ(client->large + client->small, 0u);
  EXPECT_EQ(whole.small_used(), 0u);
}

/// A client on its own may use its share. A single reservation may exceed that share if the other clients
/// leave enough.
TEST_F(ReservationTest, OneThingOfAClientMayBeLargerThanItsShare) {
  MemoryBudget whole(MemoryBudget::Divided{.capacity = 1000, .headroom = 100, .largest_small = 10},
                     {.large = 600, .small = 600});
  const auto client = std::make_shared<MemoryBudget::Client>(),
             other = std::make_shared<MemoryBudget::Client>();
  {
    MemoryBudget::Reservation large(whole, client), second(whole, client), small(whole, client);
    ASSERT_TRUE(large.grow_to(800));
    EXPECT_FALSE(second.grow_to(20));
    EXPECT_TRUE(second.over_share());
    ASSERT_TRUE(small.grow_to(10)) << "of what is for small ones";
    EXPECT_FALSE(large.grow_to(901)) << "more than there is";
    large.shrink_to(500);
    ASSERT_TRUE(second.grow_to(20));
    EXPECT_FALSE(second.grow_to(120)) << "more than its share";
    EXPECT_TRUE(second.over_share());
    MemoryBudget::Reservation theirs(whole, other);
    EXPECT_FALSE(theirs.grow_to(380))
        << "one thing, but nothing would be left, and the first has more than is its";
    EXPECT_FALSE(theirs.over_share());
    ASSERT_TRUE(theirs.grow_to(140));
  }
  EXPECT_EQ(whole.used(), 0u);
  EXPECT_EQ(client->large + client->small + other->large, 0u);
}

/// However many clients arrive, some memory is left for the next one.
TEST_F(ReservationTest, WhateverManyClientsHoldTheNextOneFindsRoom) {
  MemoryBudget whole(1'000'000, MemoryBudget::SmallPool{1000, 10}, {.large = 250'000, .small = 250});
  std::vector<MemoryBudget::Reservation> held;
  for (int client = 0; client < 250; ++client) {
    const auto name = std::make_shared<MemoryBudget::Client>();
    int taken = 0;
    for (;; ++taken) {  // takes all that it is granted, in pieces
      held.emplace_back(whole, name);
      if (!held.back().grow_to(100)) break;
    }
    ASSERT_GT(taken, 0) << "client " << client << ", while " << whole.used() << " bytes are held";
    if (client == 0) {
      EXPECT_EQ(taken, 2500) << "its share, while it is the only one";
    }
  }
}

TEST_F(ReservationTest, BackgroundWorkHoldsNoMoreThanHalfAgainstWhatOthersWaitFor) {
  using Budget = MemoryBudget;
  Budget whole(Budget::Divided{.capacity = 1000, .headroom = 0, .largest_small = 10},
               {.large = 750, .small = 750});
  const auto ana = std::make_shared<Budget::Client>(), bob = std::make_shared<Budget::Client>();
  Budget::Reservation job(whole, ana, Budget::Use::kBackground);
  ASSERT_TRUE(job.grow_to(700)) << "nobody else needs it";
  EXPECT_EQ(whole.judge(bob.get(), 300), Budget::Verdict::kFits);
  EXPECT_EQ(whole.judge(bob.get(), 400), Budget::Verdict::kHeldInBackground);
  EXPECT_EQ(whole.missing(400), 100u);
  EXPECT_EQ(whole.judge(bob.get(), 501), Budget::Verdict::kFull) << "more than the other half";
  EXPECT_EQ(whole.judge(bob.get(), 400, Budget::Use::kBackground), Budget::Verdict::kFull)
      << "as much in background";
  EXPECT_EQ(whole.judge(nullptr, 400), Budget::Verdict::kHeldInBackground);
  EXPECT_EQ(whole.judge(ana.get(), 100), Budget::Verdict::kOverShare) << "its own";
  job.shrink_to(500);
  Budget::Reservation waited(whole, bob);
  EXPECT_TRUE(waited.grow_to(400)) << "however much the job may have grown to";
  EXPECT_FALSE(job.grow_to(650));
  job = {};
  waited = {};
  EXPECT_EQ(ana->large + ana->background + bob->large + bob->background + whole.used(), 0u);
}

TEST_F(ReservationTest, LargeOnesLeaveSmallOnesTheirHeadroom) {
  MemoryBudget whole(MemoryBudget::Divided{.capacity = 1000, .headroom = 100, .largest_small = 10});
  EXPECT_EQ(whole.capacity(), 900u);
  MemoryBudget::Reservation large(whole), small(whole), another(whole);
  EXPECT_FALSE(large.grow_to(901));
  ASSERT_TRUE(large.grow_to(900));
  ASSERT_TRUE(small.grow_to(10));
  EXPECT_FALSE(small.grow_to(11)) << "it is no longer small";
  EXPECT_FALSE(another.grow_to(20));
  ASSERT_TRUE(another.grow_to(10));
  large.shrink_to(500);
  EXPECT_TRUE(small.grow_to(200));
  EXPECT_EQ(whole.used(), 710u);
}

// A request takes a few bytes, but much more is reserved for it.
TEST_F(ReservationTest, WhoAsksForMuchLeavesRoomForTheOthers) {
  std::atomic<bool> open{false};
  control->during_cut = [&](const Execution& execution) {
    while (!open) execution.poll();
  };
  const auto add = [&](const std::string& client, int sites, int seed, Priority priority = Priority::kBatch) {
    FractureRequest asked = request();
    asked.parameters.fracture.sites = sites;
    asked.parameters.fracture.seed = static_cast<std::uint64_t>(seed);
    Terms terms;
    terms.priority = priority;
    terms.payer.flow = {client, 1};
    return dispatcher.fracture(std::move(asked), terms, [](auto) {});
  };
  EXPECT_FALSE(add("greedy", 100'000, 1)) << "one alone may always run";
  ASSERT_TRUE(eventually(kPatience, "it to run", [&] { return dispatcher.figures().working_bytes > 0; }));
  EXPECT_FALSE(add("other", 10, 2));
  EXPECT_FALSE(add("greedy", 10, 3)) << "a collision of its own";
  const auto second = add("greedy", 10'000, 5);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->code, ErrorCode::kOverShare) << second->detail;
  EXPECT_FALSE(add("other", 10'000, 4)) << "a client that holds nothing waits";
  EXPECT_FALSE(add("other", 10'000, 6, Priority::kRealtime)) << "greedy gives up what exceeds its part";
  open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
}

/// Queued requests hold none of the memory for computing, whether they belong to one client or to very many.
TEST_F(ReservationTest, WhateverIsQueuedLeavesRoomForOthers) {
  Gate gate;
  control->during_cut = gate.hook_without_polls();  // It pauses for no other task.
  int taken = 0;
  const auto add = [&](const std::string& client, int seed) {
    FractureRequest asked = request();
    asked.parameters.fracture.sites = 500;
    asked.parameters.fracture.seed = static_cast<std::uint64_t>(seed);
    Terms terms;
    terms.payer.flow = {client, 1};
    return dispatcher.fracture(std::move(asked), terms, [](auto) {});
  };
  while (taken < 200 && !add("greedy", taken)) ++taken;
  EXPECT_EQ(taken, 200);
  ASSERT_TRUE(
      eventually(kPatience, "the first to run", [&] { return dispatcher.figures().working_bytes > 0; }));
  const std::uint64_t one = dispatcher.figures().working_bytes;
  for (int k = 0; k < 200; ++k) EXPECT_FALSE(add("client " + std::to_string(k), 1'000 + k)) << k;
  EXPECT_EQ(dispatcher.figures().working_bytes, one) << "of the only one that runs";
  gate.open = true;
  dispatcher.wait_idle();
}

/// Its turn comes while others hold the memory. It leaves its thread to requests that need less, and goes on
/// afterwards.
TEST_F(ReservationTest, WhoseTurnComesWithoutMemoryWaitsForIt) {
  WorkerPool two(2, 256);
  Dispatcher narrow(service, two, {.max_working_bytes = 256u << 20});
  std::atomic<bool> open{false};
  std::atomic<int> running{0};
  std::atomic<int> answers{0};
  control->during_cut = [&](const Execution& execution) {
    ++running;
    while (!open) execution.poll();
  };
  std::latch both(1);
  for (int k = 0; k < 2; ++k) two.submit(Priority::kBatch, 0, [&](int) { both.wait(); });
  const auto add = [&](const std::string& client, int sites, int seed, std::stop_token gone = {}) {
    FractureRequest asked = request();
    asked.parameters.fracture.sites = sites;
    asked.parameters.fracture.seed = static_cast<std::uint64_t>(seed);
    Terms terms;
    terms.payer.flow = {client, 1};
    terms.gone = std::move(gone);
    EXPECT_FALSE(
        narrow.fracture(std::move(asked), terms, [&](auto answer) { answers += answer.has_value(); }));
  };
  std::stop_source gone;
  add("first", 10'000, 1);  // 164 MiB of 224
  add("second", 9'000, 2);
  add("left", 9'000, 3, gone.get_token());
  both.count_down();
  ASSERT_TRUE(eventually(kPatience, "two to wait", [&] { return narrow.waiting_for_memory() == 2; }));
  EXPECT_TRUE(eventually(kPatience, "the first to run", [&] { return running == 1; }));
  add("small", 10, 4);
  ASSERT_TRUE(eventually(kPatience, "the small one to run", [&] { return running == 2; }));
  gone.request_stop();
  EXPECT_EQ(narrow.waiting_for_memory(), 1u) << "who has left holds nothing";
  open = true;
  narrow.wait_idle();
  EXPECT_EQ(narrow.waiting_for_memory(), 0u);
  EXPECT_EQ(answers, 3);
  EXPECT_EQ(control->cuts, 3);
  EXPECT_EQ(narrow.figures().working_bytes, 0u);
}

/// A computation that has its memory waits for a mesh that an upload is to prepare. The upload's turn comes
/// when no memory is left. So the upload is refused, and the computation prepares the mesh itself.
TEST_F(ReservationTest, NobodyWithMemoryWaitsForWhoWaitsForMemory) {
  WorkerPool two(2, 256);
  Dispatcher narrow(service, two, {.max_working_bytes = 64u << 20});
  std::latch begin(1);
  two.submit(Priority::kBatch, 0, [&](int) { begin.wait(); });
  two.submit(Priority::kBatch, 0, [&](int) { begin.wait(); });
  std::optional<ErrorCode> refused;
  Terms upload, computing;
  upload.payer.flow = {"upload", 1};
  computing.payer.flow = {"computing", 1};
  computing.priority = Priority::kRealtime;  // its turn comes first
  const std::string large(3u << 20, 'm');    // preparing it takes 40 MiB
  FractureRequest mesh = request();
  mesh.mesh = std::as_bytes(std::span(large));
  EXPECT_FALSE(narrow.prepare(mesh, upload, [&](auto prepared) {
    if (!prepared) refused = prepared.error().code;
  }));
  FractureRequest asked = mesh;
  asked.parameters.fracture.sites = 100;
  std::atomic<int> answers{0};
  EXPECT_FALSE(
      narrow.fracture(std::move(asked), computing, [&](auto answer) { answers += answer.has_value(); }));
  begin.count_down();
  EXPECT_TRUE(eventually(kPatience, "the answer", [&] { return answers == 1; }));
  narrow.wait_idle();
  EXPECT_TRUE(!refused || refused == ErrorCode::kOverloaded);
  EXPECT_EQ(narrow.figures().working_bytes, 0u);
}

TEST_F(ReservationTest, AMeshThatCouldNeverBeHeldIsRefusedBeforeItIsPrepared) {
  control->import = [](std::string_view) { return Expected<Mesh>(mesh_of(6'000'000)); };
  const std::optional<Error> error = ask(request());
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kTooComplex) << error->detail;
  EXPECT_EQ(control->prepares, 0);
}

TEST_F(ReservationTest, PredictionsAreRevisedWhenTheMeshIsKnown) {
  std::atomic<bool> reached{false}, go{false};
  const WorkerPool::TaskId task = pool.submit(Priority::kBatch, 0.001, [&](int) {
    reached = true;
    require_eventually(kPatience, "the test to let the job go on", [&] { return go.load(); });
  });
  ASSERT_TRUE(eventually(kPatience, "the job", [&] { return reached.load(); }));
  pool.revise(task, 1'000'000);
  EXPECT_GT(pool.predicted_wait(Priority::kBatch).count(), 1'000);
  go = true;
  pool.wait_idle();
}

TEST_F(ReservationTest, WhatNobodyWaitsForIsNotWaitedFor) {
  Gate gate;
  control->during_cut = gate.hook_without_polls();
  std::stop_source gone;
  Terms terms;
  terms.gone = gone.get_token();
  FractureRequest slow = request(2'000'000);
  slow.parameters.fracture.sites = 100'000;
  EXPECT_FALSE(dispatcher.fracture(std::move(slow), terms, [](auto) {}));
  gate.wait_for(1);
  const auto retry_after = [&] {
    const std::optional<Error> full = dispatcher.fracture(request(4'000'000), {}, [](auto) {});
    return full ? full->retry_after : std::chrono::seconds(0);
  };
  EXPECT_GT(retry_after(), std::chrono::seconds(1)) << "it is predicted to take longer";
  gone.request_stop();  // It keeps its memory until it polls.
  EXPECT_TRUE(eventually(kPatience, "the prediction to leave it out",
                         [&] { return pool.predicted_wait(Priority::kBatch).count() == 0; }));
  EXPECT_EQ(retry_after(), std::chrono::seconds(1));
  gate.open = true;
  dispatcher.wait_idle();
}

}  // namespace
}  // namespace fracture::test
