// What a computation sets aside of the memory that all share: by what is known of its mesh, put right when
// more is.
#include <gtest/gtest.h>

#include <atomic>
#include <stop_token>

#include "server/service/dispatcher.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

Mesh mesh_of(std::size_t triangles) {
  Mesh mesh;
  mesh.positions.resize(3 * triangles);
  mesh.triangles.resize(triangles);
  return mesh;
}

ServiceConfig without_mesh_cache() {
  ServiceConfig config;
  config.mesh_cache_bytes = 0;
  return config;
}

struct ReservationTest : testing::Test {
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  FractureService service{without_mesh_cache(), std::make_unique<FakeEngine>(control)};
  WorkerPool pool{1, 256};
  Dispatcher dispatcher{service, pool, {.max_working_bytes = 1u << 30}};

  FractureRequest request(std::uint64_t triangles = 0) {
    FractureRequest request;
    const auto text = std::make_shared<const std::string>("mesh");
    request.mesh = std::as_bytes(std::span(*text));
    request.owner = text;
    request.triangles = triangles;
    return request;
  }
  std::optional<Error> ask(FractureRequest asked) {
    std::optional<Error> error;
    EXPECT_FALSE(dispatcher.fracture(std::move(asked), {}, [&](Expected<FractureAnswer> answer) {
      if (!answer) error = answer.error();
    }));
    dispatcher.wait_idle();
    return error;
  }
};

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
  MemoryBudget whole(1000, {100, 10});
  const auto share = std::make_shared<MemoryBudget>(500, MemoryBudget::SmallPool{50, 10});
  {
    MemoryBudget::Reservation large(whole, share), small(whole, share);
    ASSERT_TRUE(large.grow_to(400));
    ASSERT_TRUE(small.grow_to(8));
    large.shrink_to(200);
    small.shrink_to(5);
    large.shrink_to(300);  // is less already
    EXPECT_EQ(large.bytes(), 200u);
    EXPECT_EQ(whole.used(), 205u);
    EXPECT_EQ(whole.small_used(), 5u);
    EXPECT_EQ(share->used(), 205u);
    large.shrink_to(0);
    EXPECT_EQ(large.bytes(), 11u) << "a large one still";
    EXPECT_EQ(whole.small_used(), 5u);
    ASSERT_TRUE(large.grow_to(20));
  }
  EXPECT_EQ(whole.used(), 0u);
  EXPECT_EQ(share->used(), 0u);
  EXPECT_EQ(whole.small_used(), 0u);
}

TEST_F(ReservationTest, WhatExceedsAShareAloneCountsAsAllOfIt) {
  MemoryBudget whole(MemoryBudget::Divided{.capacity = 1000, .headroom = 100, .largest_small = 10});
  const auto share = std::make_shared<MemoryBudget>(
      MemoryBudget::Divided{.capacity = 575, .headroom = 75, .largest_small = 10},
      MemoryBudget::Alone::kMayExceed);
  {
    MemoryBudget::Reservation large(whole, share), small(whole, share), second(whole, share);
    ASSERT_TRUE(large.grow_to(300));
    ASSERT_TRUE(large.grow_to(800));
    EXPECT_EQ(share->used(), 500u);
    EXPECT_FALSE(second.grow_to(20));
    EXPECT_TRUE(second.over_share());
    ASSERT_TRUE(small.grow_to(10)) << "of what is for small ones";
    ASSERT_TRUE(large.grow_to(850)) << "it has all of the share already";
    EXPECT_FALSE(large.grow_to(901));
    EXPECT_FALSE(large.over_share());
    EXPECT_EQ(share->used(), 510u);
    large.shrink_to(400);
    EXPECT_EQ(share->used(), 410u);
    EXPECT_EQ(whole.used(), 410u);
    ASSERT_TRUE(second.grow_to(80));
    EXPECT_FALSE(second.grow_to(120));
    EXPECT_TRUE(second.over_share());
    large.shrink_to(0);
    EXPECT_TRUE(second.grow_to(480));
  }
  EXPECT_EQ(whole.used(), 0u);
  EXPECT_EQ(share->used(), 0u);
}

TEST_F(ReservationTest, WhatGrowsOutOfTheHeadroomOfASmallShareIsCountedAsWhatIsLeftOfIt) {
  MemoryBudget whole(1000);
  const auto share = std::make_shared<MemoryBudget>(
      MemoryBudget::Divided{.capacity = 50, .headroom = 45, .largest_small = 10},
      MemoryBudget::Alone::kMayExceed);
  {
    MemoryBudget::Reservation alone(whole, share);
    ASSERT_TRUE(alone.grow_to(10));
    EXPECT_EQ(share->used(), 10u);
    ASSERT_TRUE(alone.grow_to(20));
    EXPECT_EQ(share->used(), 5u) << "of 50 bytes 45 are for small ones";
    EXPECT_EQ(whole.used(), 20u);
  }
  EXPECT_EQ(share->used(), 0u);
  EXPECT_EQ(whole.used(), 0u);
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

// A request is a few bytes; what is set aside for it is not.
TEST_F(ReservationTest, WhoAsksForMuchLeavesRoomForTheOthers) {
  std::atomic<bool> open{false};
  control->during_cut = [&](const Execution& execution) {
    while (!open) execution.poll();
  };
  const auto add = [&](const std::string& client, int sites, int seed) {
    FractureRequest asked = request();
    asked.parameters.fracture.sites = sites;
    asked.parameters.fracture.seed = static_cast<std::uint64_t>(seed);
    Terms terms;
    terms.payer.flow = {client, 1};
    return dispatcher.fracture(std::move(asked), terms, [](auto) {});
  };
  EXPECT_FALSE(add("greedy", 100'000, 1)) << "one alone may always run";
  EXPECT_FALSE(add("other", 10, 2));
  EXPECT_FALSE(add("greedy", 10, 3)) << "a collision of its own";
  const auto second = add("greedy", 10'000, 5);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->code, ErrorCode::kOverShare) << second->detail;
  const auto large = add("other", 10'000, 4);
  ASSERT_TRUE(large);
  EXPECT_EQ(large->code, ErrorCode::kOverloaded) << large->detail;
  open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
}

TEST_F(ReservationTest, ManySmallOnesOfOneClientLeaveRoomForOthers) {
  std::atomic<bool> open{false};
  control->during_cut = [&](const Execution& execution) {
    while (!open) execution.poll();
  };
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
  EXPECT_GT(taken, 40);
  EXPECT_LE(dispatcher.figures().working_bytes, (1u << 30) / 32 * 27) << "3/4 of all, and of an eighth";
  for (int k = 0; k < 12; ++k) EXPECT_FALSE(add("other", 1'000 + k)) << k;
  open = true;
  dispatcher.wait_idle();
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
  gone.request_stop();  // it has its memory until it polls
  EXPECT_TRUE(eventually(kPatience, "the prediction to leave it out",
                         [&] { return pool.predicted_wait(Priority::kBatch).count() == 0; }));
  EXPECT_EQ(retry_after(), std::chrono::seconds(1));
  gate.open = true;
  dispatcher.wait_idle();
}

}  // namespace
}  // namespace fracture::test
