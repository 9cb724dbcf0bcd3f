// The order in which clients get turns on the I/O threads. A model of Asio's queue of handlers takes the
// place of the threads, so the tests count positions instead of measuring times.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/http/turn_wait.hpp"

namespace fracture::http {
namespace {

/// Handlers run one after the other, in the order in which they became ready.
struct EventModel {
  explicit EventModel(std::size_t threads = 1)
      : turns(threads, [this](IoTurns::Call call) { ready.push_back(std::move(call)); }) {}
  ~EventModel() { turns.stop(); }

  void run_one() {
    const IoTurns::Call call = std::move(ready.front());
    ready.pop_front();
    used = 0;
    call();
    turns.end_turn(used);
  }
  void run() {
    while (!ready.empty()) run_one();
  }
  /// Runs until `n` requests have been handled.
  void handle(std::size_t n) {
    while (handled.size() < n && !ready.empty()) run_one();
  }
  std::size_t count(const std::string& name) const {
    return static_cast<std::size_t>(std::count(handled.begin(), handled.end(), name));
  }

  std::deque<IoTurns::Call> ready;
  IoTurns turns;
  double used = 0;  // seconds, in the current turn
  std::vector<std::string> handled;
};

/// A connection on which `requests` requests have arrived already. It behaves as a session does: it asks for
/// a turn, handles the request, and becomes ready again when its answer is written.
struct Peer {
  Peer(EventModel& in, std::string client, int count, double cost = 0.001)
      : model(in), flow{std::move(client)}, requests(count), seconds(cost) {}
  void arrive() {
    model.ready.emplace_back([this] { next(); });
  }
  void next() {
    if (requests == 0) return;
    --requests;
    if (model.turns.begin(flow)) return handle();
    place.emplace(model.turns.wait(flow, [this] { model.ready.emplace_back([this] { resume(); }); }));
  }
  void resume() {
    if (!place || !place->take()) return;
    place.reset();
    handle();
  }
  void handle() {
    model.used += seconds;
    model.handled.push_back(flow.name);
    arrive();
  }

  EventModel& model;
  Flow flow;
  int requests;
  double seconds;
  std::optional<IoTurns::Place> place;
};

using Peers = std::deque<Peer>;

Peers connect(EventModel& model, const std::string& client, int connections, int requests,
              double seconds = 0.001) {
  Peers all;
  for (int k = 0; k < connections; ++k) all.emplace_back(model, client, requests, seconds);
  for (Peer& peer : all) peer.arrive();
  return all;
}

TEST(IoTurnOrder, ALoneClientNeverWaitsBetweenItsRequests) {
  EventModel model;
  for (int k = 0; k < 3; ++k) {
    EXPECT_TRUE(model.turns.begin({"a"}));
    EXPECT_TRUE(model.turns.begin({"a"})) << "a request that arrives complete needs only one turn";
    model.turns.end_turn(0.001);
    EXPECT_EQ(model.ready.size(), 1u);
    model.run();
  }
  EXPECT_EQ(model.turns.waiting(), 0u);
}

/// In the order of connections, 60 requests of the flood would come between.
TEST(IoTurnOrder, AFloodOfConnectionsDelaysAnotherClientByAtMostTwoRequestsPerThread) {
  for (const std::size_t threads : {1u, 2u}) {
    EventModel model(threads);
    Peers flood = connect(model, "flood", 60, 1000), others;
    for (std::size_t k = 1; k <= 20; ++k) {
      model.handle(model.handled.size() + 97);
      const std::size_t before = model.count("flood");
      others.emplace_back(model, "other", 1).arrive();
      while (model.count("other") < k && !model.ready.empty()) model.run_one();
      ASSERT_EQ(model.count("other"), k);
      EXPECT_LE(model.count("flood") - before, 2 * threads) << threads;
    }
    model.run();
    EXPECT_EQ(model.count("flood"), 60'000u) << "nothing is lost";
  }
}

TEST(IoTurnOrder, ClientsShareTheTimeAndNotTheNumberOfRequests) {
  EventModel model;
  Peers long_ones = connect(model, "long", 60, 1000, 0.01),
        short_ones = connect(model, "short", 60, 1000, 0.001);
  model.handle(1100);  // 100 times 10 ms and 1000 times 1 ms
  EXPECT_NEAR(static_cast<double>(model.count("long")), 100, 5);
}

TEST(IoTurnOrder, RequestsOfOneClientAreServedInTheOrderOfArrival) {
  EventModel model;
  std::vector<int> order;
  std::vector<std::unique_ptr<IoTurns::Place>> places;
  ASSERT_TRUE(model.turns.begin({"a"}));
  model.turns.end_turn(0);
  for (int k = 0; k < 5; ++k) {
    ASSERT_FALSE(model.turns.begin({"a"}));
    model.turns.end_turn(0);
    places.push_back(std::make_unique<IoTurns::Place>(model.turns.wait({"a"}, [&, k] {
      model.ready.emplace_back([&, k] {
        order.push_back(k);
        EXPECT_TRUE(places[static_cast<std::size_t>(k)]->take());
      });
    })));
  }
  model.run();
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST(IoTurnOrder, ARequestThatLeavesTakesNoTurn) {
  EventModel model;
  ASSERT_TRUE(model.turns.begin({"a"}));
  model.turns.end_turn(0);
  int woken = 0;
  std::optional<IoTurns::Place> first, second, third;
  first.emplace(model.turns.wait({"b"}, [&] { ++woken; }));
  second.emplace(model.turns.wait({"b"}, [&] { ++woken; }));
  third.emplace(model.turns.wait({"b"}, [&] { ++woken; }));
  EXPECT_EQ(model.turns.waiting(), 3u);
  first.reset();
  EXPECT_EQ(model.turns.waiting(), 2u);
  model.run();
  EXPECT_EQ(woken, 1);
  EXPECT_TRUE(second->granted());
  EXPECT_FALSE(third->granted());
  second.reset();  // leaves although it has been granted the turn
  model.run();
  EXPECT_EQ(woken, 2);
  ASSERT_TRUE(third->take());
  model.turns.end_turn(0);
  model.run();
  EXPECT_TRUE(model.turns.begin({"c"})) << "the thread is free again";
  model.turns.end_turn(0);
}

TEST(IoTurnOrder, AfterTheEndNothingIsScheduled) {
  EventModel model;
  ASSERT_TRUE(model.turns.begin({"a"}));
  model.turns.end_turn(0);
  std::optional<IoTurns::Place> granted(model.turns.wait({"b"}, [] {})),
      waits(model.turns.wait({"b"}, [] {}));
  model.run();
  ASSERT_TRUE(granted->granted());
  model.turns.stop();
  granted.reset();
  waits.reset();
  EXPECT_TRUE(model.ready.empty());
  EXPECT_EQ(model.turns.waiting(), 0u);
}

// -- the wait of a connection

struct TurnWaits : testing::Test {
  asio::io_context context;
  std::deque<IoTurns::Call> later;
  IoTurns turns{1, [this](IoTurns::Call call) { later.push_back(std::move(call)); }};
  Flow flow{"b"};
  std::shared_ptr<TurnWait> wait = std::make_shared<TurnWait>(&turns, asio::make_strand(context));
  std::optional<bool> came;

  void SetUp() override {  // another client's request has the turn
    ASSERT_TRUE(turns.begin({"a"}));
    turns.end_turn(0);
  }
  void TearDown() override { turns.stop(); }
  void begin(TurnWait::Clock::duration patience) {
    EXPECT_FALSE(wait->at_once(flow));
    turns.end_turn(0);
    const auto end = TurnWait::Clock::now() + patience;
    asio::co_spawn(
        context,
        [this, end]() -> asio::awaitable<void> {
          const bool result = co_await wait->until_turn(flow, end);
          came = result;
        },
        asio::detached);
    context.poll();
    EXPECT_EQ(turns.waiting(), 1u);
    EXPECT_FALSE(came);
  }
  void run() {
    context.restart();
    context.run();
    turns.end_turn(0);
  }
};

TEST_F(TurnWaits, EndsWhenTheTurnIsGranted) {
  begin(std::chrono::hours(1));
  ASSERT_EQ(later.size(), 1u);
  std::exchange(later, {}).front()();
  run();
  EXPECT_EQ(came, true);
  ASSERT_EQ(later.size(), 1u) << "the turn ends, too";
  later.front()();
  EXPECT_TRUE(wait->at_once(flow));
  turns.end_turn(0);
}

TEST_F(TurnWaits, HasAnEnd) {
  begin(std::chrono::seconds(3));
  run();
  EXPECT_EQ(came, false);
  EXPECT_EQ(turns.waiting(), 0u);
}

TEST_F(TurnWaits, EndsWhenItIsCancelled) {
  begin(std::chrono::hours(1));
  wait->cancel();
  run();
  EXPECT_EQ(came, false);
  EXPECT_EQ(turns.waiting(), 0u);
}

TEST_F(TurnWaits, ATurnThatIsGrantedToACancelledRequestGoesToTheNext) {
  begin(std::chrono::hours(1));
  bool next = false;
  const IoTurns::Place place = turns.wait({"c"}, [&] { next = true; });
  std::exchange(later, {}).front()();
  wait->cancel();
  run();
  EXPECT_EQ(came, false);
  ASSERT_EQ(later.size(), 1u);
  std::exchange(later, {}).front()();
  EXPECT_TRUE(next);
}

TEST_F(TurnWaits, WithoutTurnsEveryRequestBeginsAtOnce) {
  EXPECT_TRUE(std::make_shared<TurnWait>(nullptr, context.get_executor())->at_once(flow));
}

}  // namespace
}  // namespace fracture::http
