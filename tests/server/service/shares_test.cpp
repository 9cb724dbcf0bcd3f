// How computations are charged: all clients that waited for one pay for the measured time. Also tests how
// much a name may have at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <latch>
#include <mutex>
#include <stop_token>
#include <vector>

#include "common/base/processor_time.hpp"
#include "server/service/dispatcher.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/fracture_request.hpp"
#include "tests/support/eventually.hpp"

namespace fracture {
namespace {

using test::eventually;
using test::fracture_request;
using test::kPatience;

/// Computes until this thread has used `seconds` of processor time.
void spend(double seconds) {
  const double begin = processor_seconds_of_this_thread();
  while (processor_seconds_of_this_thread() < begin + seconds) {
  }
}

struct Shares : testing::Test {
  std::shared_ptr<test::FakeControl> control = std::make_shared<test::FakeControl>();
  FractureService service{ServiceConfig{}, std::make_unique<test::FakeEngine>(control)};
  WorkerPool pool{2, 256};
  Dispatcher dispatcher{service, pool};
  std::atomic<int> answered{0};

  static Terms of(const std::string& name, const tenants::Shares& shares = {}) {
    Terms terms;
    terms.payer.account =
        std::make_shared<tenants::Account>(tenants::Tenant{name, {}, {}, shares}, /*isolated=*/true);
    terms.payer.flow = {name, 1};
    return terms;
  }
  std::optional<Error> ask(FractureRequest r, const Terms& terms) {
    return dispatcher.fracture(std::move(r), terms, [this](Expected<FractureAnswer>) { ++answered; });
  }
  static double charged(const Terms& terms) { return terms.payer.account->figures().processor_seconds; }
};

/// A popular request that another client has at the end of its own queue.
TEST_F(Shares, WhoAsksForTheSameDoesNotWaitBehindTheQueueOfAnother) {
  WorkerPool one(1, 256);
  Dispatcher narrow(service, one);
  std::atomic<bool> open{false};
  std::vector<std::uint64_t> order;  // seeds in the order in which the only thread computes them
  control->during_cut = [&](const Execution& execution) {
    while (!open) execution.poll();
  };
  std::mutex mutex;
  const auto ask_for = [&](const std::string& client, std::uint64_t seed, Priority priority) {
    Terms terms;
    terms.payer.flow = {client, 1};
    terms.priority = priority;
    EXPECT_FALSE(narrow.fracture(fracture_request("mesh", seed), terms, [&, seed](Expected<FractureAnswer>) {
      const std::lock_guard lock(mutex);
      order.push_back(seed);
    }));
  };
  for (const Priority priority : {Priority::kBatch, Priority::kBackground}) {
    open = false;
    order.clear();
    const std::uint64_t first = priority == Priority::kBatch ? 100 : 200;
    for (std::uint64_t k = 0; k < 50; ++k) ask_for("greedy", first + k, priority);
    ask_for("modest", first + 49, priority);
    open = true;
    narrow.wait_idle();
    EXPECT_EQ(control->cuts.exchange(0), 50);
    const auto at = std::find(order.begin(), order.end(), first + 49) - order.begin();
    EXPECT_LE(at, 2) << "behind what ran, and what was next";
  }
}

TEST_F(Shares, EverybodyWhoWaitedIsChargedForAllOfItOnce) {
  std::atomic<bool> open{false};
  control->during_cut = [&](const Execution& execution) {
    while (!open) execution.poll();
    spend(0.05);
  };
  const Terms a = of("a"), b = of("b"), c = of("c");
  for (const Terms* terms : {&a, &b, &b, &b}) EXPECT_FALSE(ask(fracture_request("mesh"), *terms));
  open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(control->cuts, 1);
  EXPECT_GE(charged(a), 0.05);
  EXPECT_DOUBLE_EQ(charged(a), charged(b)) << "three requests of one name are one payer";
  EXPECT_FALSE(ask(fracture_request("mesh"), c));
  EXPECT_EQ(charged(c), 0) << "from the cache";
  EXPECT_EQ(answered, 5);
}

TEST(Payers, WhoComesAfterTheChargeOwesAllOfIt) {
  Payers payers;
  EXPECT_EQ(payers.add({nullptr, {"a", 1}}, Priority::kBatch), 0);
  EXPECT_EQ(payers.charge(0.5).size(), 1u);
  EXPECT_EQ(payers.charge(0.25).size(), 1u);
  EXPECT_EQ(payers.add({nullptr, {"b", 1}}, Priority::kRealtime), 0.75);
  EXPECT_EQ(payers.add({nullptr, {"a", 1}}, Priority::kBatch), 0) << "has paid";
  EXPECT_EQ(payers.add({nullptr, {"b", 1}}, Priority::kBatch), 0) << "is told once";
  const std::vector<Waits> all = payers.charge(1);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1].priority, Priority::kRealtime);
}

TEST_F(Shares, EachPaysInTheClassOfItsOwnRequest) {
  WorkerPool one(1, 256);
  Dispatcher single(service, one);
  std::latch gate(1);
  std::atomic<bool> first{true};
  std::mutex mutex;
  std::string order;
  control->during_cut = [&](const Execution&) {
    if (first.exchange(false)) gate.wait();
  };
  control->import = [&](std::string_view mesh) -> Expected<Mesh> {
    if (mesh.front() == 'p') spend(0.05);
    const std::lock_guard lock(mutex);
    order += mesh.front();
    return Mesh{};
  };
  Terms batch = of("a"), hurried = of("b"), own = batch;
  hurried.priority = own.priority = Priority::kRealtime;
  const auto ask_single = [&](const std::string& mesh, const Terms& terms) {
    EXPECT_FALSE(single.fracture(fracture_request(mesh), terms, [](const auto&) {}));
  };
  ask_single("gate", of("c"));
  EXPECT_TRUE(eventually(kPatience, "the thread to be taken", [&] { return !first; }));
  ask_single("p", batch);
  ask_single("p", hurried);  // which makes it realtime, at b's cost
  for (int k = 0; k < 3; ++k) {
    ask_single(std::string("b") += std::to_string(k), hurried);
    ask_single(std::string("a") += std::to_string(k), own);
  }
  gate.count_down();
  single.wait_idle();
  EXPECT_EQ(order.substr(0, 3), "gpb")
      << "both have paid for it, whatever the class: who came first goes first";
  EXPECT_GE(charged(batch), 0.05);
  EXPECT_GE(charged(hurried), 0.05);
}

TEST_F(Shares, WhoLeavesHalfWayPaysForTheHalf) {
  std::stop_source gone;
  std::atomic<bool> spent{false};
  control->during_cut = [&](const Execution& execution) {
    spend(0.05);
    spent = true;
    for (;;) execution.poll();
  };
  Terms a = of("a");
  a.gone = gone.get_token();
  EXPECT_FALSE(ask(fracture_request("mesh"), a));
  EXPECT_TRUE(eventually(kPatience, "half of it", [&] { return spent.load(); }));
  gone.request_stop();
  dispatcher.wait_idle();
  EXPECT_TRUE(eventually(kPatience, "the charge", [&] { return charged(a) >= 0.05; }));
}

TEST_F(Shares, AMeshThatSeveralWaitForIsChargedToAllOfThem) {
  std::latch gate(1);
  control->import = [&](std::string_view) -> Expected<Mesh> {
    gate.wait();
    spend(0.05);
    return Mesh{};
  };
  const Terms a = of("a"), b = of("b");
  EXPECT_FALSE(ask(fracture_request("mesh", 1), a));
  EXPECT_TRUE(eventually(kPatience, "the import", [&] { return control->imports == 1; }));
  EXPECT_FALSE(ask(fracture_request("mesh", 2), b));
  EXPECT_TRUE(eventually(kPatience, "the second to wait for the mesh",
                         [&] { return pool.queued() == 0 && pool.running() == 1; }));
  gate.count_down();
  dispatcher.wait_idle();
  EXPECT_EQ(control->imports, 1);
  EXPECT_GE(charged(a), 0.05);
  EXPECT_GE(charged(b), 0.05);
}

TEST_F(Shares, ANameHasSoManyComputationsAtTheSameTime) {
  std::atomic<bool> open{false};
  control->during_cut = [&](const Execution& execution) {
    while (!open) execution.poll();
  };
  tenants::Shares two;
  two.computations = 2;
  const Terms a = of("a", two), b = of("b", two);
  EXPECT_FALSE(ask(fracture_request("mesh", 1), a));
  EXPECT_FALSE(ask(fracture_request("mesh", 2), a));
  const auto over = ask(fracture_request("mesh", 3), a);
  ASSERT_TRUE(over);
  EXPECT_EQ(over->code, ErrorCode::kOverShare);
  EXPECT_GE(over->retry_after.count(), 1);
  EXPECT_FALSE(ask(fracture_request("mesh", 3), b)) << "the others are not concerned";
  open = true;
  dispatcher.wait_idle();
  EXPECT_FALSE(ask(fracture_request("mesh", 4), a)) << "the places are free again";
  dispatcher.wait_idle();
  EXPECT_EQ(a.payer.account->figures().computations, 0u);
}

TEST_F(Shares, WhatWasMeasuredDecidesWhoseTurnItIs) {
  WorkerPool one(1, 256);
  Dispatcher single(service, one);
  std::latch gate(1);
  std::atomic<bool> first{true};
  std::mutex mutex;
  std::string order;
  control->import = [&](std::string_view mesh) -> Expected<Mesh> {
    if (first.exchange(false)) gate.wait();
    if (mesh.front() == 'a') spend(0.03);
    const std::lock_guard lock(mutex);
    order += mesh.front();
    return Mesh{};
  };
  const Terms a = of("a"), b = of("b");
  std::atomic<int> done{0};
  const auto add = [&](const char* name, int k, const Terms& terms) {
    EXPECT_FALSE(single.fracture(fracture_request(name + std::to_string(k)), terms,
                                 [&](Expected<FractureAnswer> answer) { done += answer.has_value(); }));
  };
  for (int k = 0; k < 12; ++k) add("a", k, a);
  for (int k = 0; k < 12; ++k) add("b", k, b);
  gate.count_down();
  single.wait_idle();
  EXPECT_EQ(done, 24);
  // The meshes of a took 30 ms each and those of b next to nothing, although both had the same expected cost.
  const std::size_t last_of_b = order.rfind('b');
  EXPECT_LT(std::count(order.begin(), order.begin() + static_cast<long>(last_of_b), 'a'), 6) << order;
}

TEST_F(Shares, ABatchComputationStandsStillAtItsPollsAndARealtimeOneIsAnswered) {
  WorkerPool one(1, 256);
  Dispatcher single(service, one);
  std::atomic<bool> open{false};
  std::atomic<int> begun{0};
  control->during_cut = [&](const Execution& execution) {
    if (begun++ > 0) return;
    while (!open) execution.poll();
  };
  Terms batch = of("a"), realtime = of("b");
  realtime.priority = Priority::kRealtime;
  std::atomic<bool> batch_done{false}, realtime_done{false};
  EXPECT_FALSE(single.fracture(fracture_request("long"), batch,
                               [&](auto answer) { batch_done = answer.has_value(); }));
  EXPECT_TRUE(eventually(kPatience, "the batch computation to begin", [&] { return begun == 1; }));
  EXPECT_FALSE(single.fracture(fracture_request("short"), realtime,
                               [&](auto answer) { realtime_done = answer.has_value(); }));
  EXPECT_TRUE(eventually(kPatience, "the realtime answer", [&] { return realtime_done.load(); }));
  EXPECT_FALSE(batch_done);
  open = true;
  single.wait_idle();
  EXPECT_TRUE(batch_done);
}

}  // namespace
}  // namespace fracture
