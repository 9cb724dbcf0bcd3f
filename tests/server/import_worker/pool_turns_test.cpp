// Imports take turns: the time that they use is charged to their computations, and no import reads forever
// while others wait. The client that has read for the shortest time comes next.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <deque>
#include <fstream>
#include <future>
#include <iterator>
#include <stop_token>
#include <thread>

#include "tests/server/support/import_pool_fixture.hpp"

namespace fracture::test {
namespace {

/// The turn of a computation whose urgency the test decides. It counts the time that is charged to it.
struct ToldTurn : Turn {
  explicit ToldTurn(bool urgent) : is_in_a_hurry(urgent) {}
  void give_way() override {}
  void leave() override {}
  void come_back() override {}
  bool is_urgent() const override {
    ++asked;
    return is_in_a_hurry;
  }
  void spent_elsewhere(double seconds) override { spent = spent + seconds; }
  std::atomic<bool> is_in_a_hurry;
  mutable std::atomic<int> asked{0};
  std::atomic<double> spent{0};
};

TEST(ImportPool, WhatAnImportSpendsIsSaidAndNotWhatItWaits) {
  constexpr std::chrono::duration<double> kWaits{1.0};
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  ToldTurn spins(false), hangs(false), waits(false);
  const auto import_for = [&](ToldTurn& turn, std::string_view file, std::chrono::duration<double> patience) {
    Execution execution;
    execution.turn = &turn;
    execution.deadline = std::chrono::steady_clock::now() +
                         std::chrono::duration_cast<std::chrono::steady_clock::duration>(patience);
    return import_with(pool, file, execution);
  };
  // On a busy machine the import gets only a part of the time, so it may take longer and longer.
  for (auto patience = kWaits; spins.spent <= 0.05 && patience < kPatience; patience *= 2)
    EXPECT_THROW((void)import_for(spins, "! spin", patience), Interrupted);
  EXPECT_GT(spins.spent, 0.05);
  auto hanging = std::async(std::launch::async,
                            [&] { EXPECT_THROW((void)import_for(hangs, "! hang", kWaits), Interrupted); });
  EXPECT_TRUE(eventually(kPatience, "a worker to be busy", [&] { return pool.counters().busy == 1; }));
  EXPECT_TRUE(import_for(waits, kTetrahedron, kPatience));
  hanging.get();
  EXPECT_GT(waits.spent, 0);
  EXPECT_LT(waits.spent, 0.5 * kWaits.count());
}

/// An import that does not end by itself, for as long as this object lives.
struct Endless {
  Endless(ImportPool& pool, const char* command, Turn* turn, const Flow& flow = {}) {
    Execution execution;
    execution.stop = stop.get_token();
    execution.turn = turn;
    thread = std::thread([&pool, command, execution, flow] {
      try {
        (void)import_with(pool, command, execution, flow);
        ADD_FAILURE() << "it should have been interrupted";
      } catch (const Interrupted& interrupted) {
        EXPECT_EQ(interrupted.code, ErrorCode::kCancelled);
      }
    });
  }
  ~Endless() {
    stop.request_stop();
    thread.join();
  }
  std::stop_source stop;
  std::thread thread;
};

/// Imports a mesh for a client that waits no longer than the tests' patience.
Expected<Mesh> read_for(ImportPool& pool, Turn& turn, const Flow& flow = {}) {
  Execution execution;
  execution.turn = &turn;
  execution.deadline = std::chrono::steady_clock::now() + kPatience;
  return import_with(pool, kTetrahedron, execution, flow);
}

bool are(const ImportPool& pool, int busy, int standing) {
  return eventually(kPatience, "so many to read and to stand still", [&] {
    const ImportCounters counters = pool.counters();
    return counters.busy == busy && counters.standing == standing;
  });
}

TEST(ImportPool, ImportsTakeTurns) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 2));
  ToldTurn turns[4] = {ToldTurn(false), ToldTurn(false), ToldTurn(false), ToldTurn(false)};
  {
    const Endless first(pool, "! hang", &turns[0]), second(pool, "! spin", &turns[1]);
    EXPECT_TRUE(are(pool, 2, 0));
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(read_for(pool, turns[2])) << k;
    const Endless third(pool, "! hang", &turns[3]);
    EXPECT_TRUE(are(pool, 2, 1));
    EXPECT_TRUE(read_for(pool, turns[2]));
  }
  EXPECT_TRUE(settles(pool));
  EXPECT_EQ(pool.counters().standing, 0);
  EXPECT_EQ(pool.counters().interrupted, 3u);
  EXPECT_EQ(pool.counters().imported, 4u);
}

TEST(ImportPool, UrgentWorkHasItsTurnAtOnceAndKeepsIt) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  ToldTurn batch(false), realtime(true), hurried(false);
  {
    const Endless slow(pool, "! hang", &batch);
    EXPECT_TRUE(are(pool, 1, 0));
    const Endless urgent(pool, "! spin", &realtime);
    EXPECT_TRUE(are(pool, 1, 1));
    const double before = batch.spent;
    // An urgent client begins to wait for this import while it waits.
    auto promoted = std::async(std::launch::async, [&] { return read_for(pool, hurried); });
    const int asked = hurried.asked;
    EXPECT_TRUE(eventually(kPatience, "it to wait", [&] { return hurried.asked >= asked + 20; }));
    EXPECT_EQ(pool.counters().imported, 0u);
    EXPECT_EQ(batch.spent, before) << "it was stopped";
    hurried.is_in_a_hurry = true;
    EXPECT_TRUE(promoted.get());
  }
  EXPECT_TRUE(settles(pool));
  EXPECT_EQ(pool.counters().workers, 1);
}

TEST(ImportPool, WorkThatIsUrgentNoMoreKeepsNobodyWaiting) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  ToldTurn left(true), batch(false);
  {
    const Endless hangs(pool, "! hang", &left);
    EXPECT_TRUE(are(pool, 1, 0));
    left.is_in_a_hurry = false;
    EXPECT_TRUE(read_for(pool, batch));
  }
  EXPECT_TRUE(settles(pool));
}

/// Counts how often imports begin or continue after they have waited.
struct CountingTurn : ToldTurn {
  using ToldTurn::ToldTurn;
  void come_back() override { ++begun; }
  std::atomic<int> begun{0};
};

/// The turn of one import. Counts how often the others begin or continue from the time at which it joins the line until it
/// begins. The pool asks for its urgency when it joins, under the lock under which imports begin.
struct NextTurn : ToldTurn {
  explicit NextTurn(const std::atomic<int>& others_begun) : ToldTurn(false), begun(others_begun) {}
  bool is_urgent() const override {
    if (joined < 0) joined = begun.load();
    return false;
  }
  void come_back() override {
    if (others < 0) others = begun - joined;
  }
  const std::atomic<int>& begun;
  mutable std::atomic<int> joined{-1};
  std::atomic<int> others{-1};
};

/// Endless imports of one client. They take turns in a worker, in which they sleep.
struct Flood {
  Flood(ImportPool& pool, Turn* turn, int count) {
    for (int k = 0; k < count; ++k) imports.emplace_back(pool, "! hang", turn, Flow{.name = "many"});
  }
  std::deque<Endless> imports{};
};

TEST(ImportPool, OneImportOfAClientIsNextHoweverManyAnotherHasInLine) {
  for (const bool urgent : {false, true}) {
    ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
    CountingTurn many(urgent);
    NextTurn one(many.begun);
    {
      const Flood flood(pool, &many, 20);
      EXPECT_TRUE(eventually(kPatience, "some to have had their turn", [&] { return many.begun >= 4; }));
      EXPECT_TRUE(read_for(pool, one, {.name = "one"}));
      EXPECT_LE(one.others, 0) << "urgent: " << urgent;
      const int before = many.begun;
      EXPECT_TRUE(eventually(kPatience, "them to go on", [&] { return many.begun >= before + 3; }));
    }
    EXPECT_TRUE(settles(pool));
    EXPECT_EQ(pool.counters().imported, 1u);
    EXPECT_EQ(pool.counters().standing, 0);
  }
}

TEST(ImportPool, ClientsThatAlwaysReadGetTheSameTimeHoweverManyImportsTheyHave) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  CountingTurn many(false), one(false);
  {
    const Flood flood(pool, &many, 20);
    EXPECT_TRUE(eventually(kPatience, "some to have had their turn", [&] { return many.begun >= 4; }));
    const int before = many.begun;
    const Endless endless(pool, "! hang", &one, Flow{.name = "one"});
    EXPECT_TRUE(eventually(kPatience, "it to have had ten turns", [&] { return one.begun >= 10; }));
    EXPECT_LT(many.begun - before, 100) << "200 if imports shared the time, 10 if clients do";
  }
  EXPECT_TRUE(settles(pool));
}

/// State of a process in /proc: "R" (runs), "S" (sleeps), "T" (stopped by a signal).
std::string state_of(pid_t process) {
  std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
  const std::string text{std::istreambuf_iterator<char>(stat), {}};
  return text.substr(text.rfind(')') + 2, 1);
}

/// A computation that pauses for another one.
TEST(ImportPool, AnImportStandsStillWithItsComputation) {
  struct Standing : ToldTurn {
    Standing() : ToldTurn(false) {}
    void give_way() override {
      ++calls;
      require_eventually(kPatience, "it to be allowed to go on", [this] { return !stands; });
    }
    std::atomic<bool> stands{false};
    std::atomic<int> calls{0};
  } turn;
  ToldTurn other(false);
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  std::stop_source stop;
  Execution execution;
  execution.turn = &turn;
  execution.stop = stop.get_token();
  std::thread spins([&] {
    const std::string file = "! spin";
    EXPECT_THROW((void)pool.import(bytes_of(file), MeshFormat::kOff, {}, {}, execution, digest_of(file),
                                   [&] { return turn.stands.load(); }),
                 Interrupted);
  });
  EXPECT_TRUE(are(pool, 1, 0));
  turn.stands = true;
  EXPECT_TRUE(are(pool, 0, 1));
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(read_for(pool, other)) << "its place is free";
  const pid_t reader = pool.pids().front();
  // The kernel stops a process some time after it takes the signal, so the state changes later than the pool's counters.
  EXPECT_TRUE(
      eventually(kPatience, "the signal to stop the worker", [&] { return state_of(reader) == "T"; }));
  turn.stands = false;
  EXPECT_TRUE(are(pool, 1, 0));
  stop.request_stop();
  spins.join();
  EXPECT_TRUE(settles(pool));
}

}  // namespace
}  // namespace fracture::test
