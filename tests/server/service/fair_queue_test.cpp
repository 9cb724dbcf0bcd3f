// Start-time fair queueing: who is served when, counted by hand from the tags of the paper.
#include "server/service/fair_queue.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <random>

namespace fracture {
namespace {

using Places = std::vector<std::optional<std::size_t>>;

struct Item {
  std::uint64_t id;
  double cost;
  Flow flow;
};

struct Queue : FairQueue<Item> {
  std::uint64_t last = 0;
  std::uint64_t add(const std::string& flow, double cost = 1, double weight = 1) {
    push({++last, cost, {flow, weight}});
    return last;
  }
  std::string serve(int n = 1000) {
    std::string served;
    for (; n > 0 && !empty(); --n) served += pop().flow.name;
    return served;
  }
};

TEST(FairQueue, OneFlowIsServedInTheOrderOfArrival) {
  Queue queue;
  for (const double cost : {5.0, 0.0, 1.0}) queue.add("a", cost);
  EXPECT_EQ(queue.places({3, 1, 2}), (Places{2, 0, 1}));
  for (std::uint64_t id = 1; id <= 3; ++id) EXPECT_EQ(queue.pop().id, id);
}

TEST(FairQueue, AFloodDelaysAnotherByOneTaskOnly) {
  Queue queue;
  for (int k = 0; k < 100; ++k) queue.add("a");
  EXPECT_EQ(queue.serve(10), std::string(10, 'a'));
  queue.add("b");
  queue.add("b");
  EXPECT_EQ(queue.serve(4), "baba") << "its start tag is that of the task in service";
}

TEST(FairQueue, WhoWasIdleHasNoCreditForIt) {
  Queue queue;
  for (int k = 0; k < 20; ++k) queue.add("a");
  queue.serve(10);
  for (int k = 0; k < 10; ++k) queue.add("b");
  EXPECT_EQ(queue.serve(8), "babababa");
}

TEST(FairQueue, SharesAreByWeightAndByWhatTasksCost) {
  Queue queue;
  for (int k = 0; k < 90; ++k) queue.add("a", 1, 2);
  for (int k = 0; k < 90; ++k) queue.add("b", 1, 1);
  for (int k = 0; k < 90; ++k) queue.add("c", 3, 3);
  std::map<char, int> count;
  for (const char flow : queue.serve(80)) ++count[flow];
  EXPECT_NEAR(count['a'], 40, 1);  // twice the weight of b
  EXPECT_NEAR(count['b'], 20, 1);
  EXPECT_NEAR(count['c'], 20, 1);  // three times the weight, at three times the cost
}

TEST(FairQueue, WhatWasMeasuredCountsAndNotWhatWasSaid) {
  Queue queue;
  for (int k = 0; k < 20; ++k) queue.add("a", 1);
  for (int k = 0; k < 20; ++k) queue.add("b", 1);
  std::string served;
  while (served.size() < 16) {
    const Item item = queue.pop();
    served += item.flow.name;
    if (item.flow.name == "a") queue.charge(item.flow, 2);  // it took three
  }
  EXPECT_EQ(std::count(served.begin(), served.end(), 'a'), 4) << served;
}

TEST(FairQueue, WhoWaitedForAnothersTaskPaysToo) {
  Queue queue;
  for (int k = 0; k < 10; ++k) queue.add("a");
  queue.pop();
  queue.charge({"b", 1}, 5);
  queue.add("b");
  EXPECT_EQ(queue.serve(6), "aaaaab");
}

TEST(FairQueue, TheOrderIsForetold) {
  std::mt19937 random(7);
  Queue queue;
  for (int k = 0; k < 200; ++k)
    queue.add(std::string(1, static_cast<char>('a' + random() % 5)), 0.25 * (1 + random() % 8), 1);
  std::vector<std::uint64_t> ids(200);
  std::iota(ids.begin(), ids.end(), 1);
  const Places foretold = queue.places(ids), of_some = queue.places({150, 201, 150, 3});
  EXPECT_EQ(of_some, (Places{foretold[149], std::nullopt, foretold[149], foretold[2]})) << "each by itself";
  EXPECT_TRUE(queue.places({}).empty());
  for (std::size_t k = 0; k < 200; ++k) ASSERT_EQ(foretold.at(queue.pop().id - 1), k);
  EXPECT_TRUE(queue.empty());
}

TEST(FairQueue, WhatGoesBeforeANewTaskIsItsFlowsTurnAndNotTheWholeQueue) {
  Queue queue;
  for (int k = 0; k < 100; ++k) queue.add("a", 1);
  EXPECT_DOUBLE_EQ(queue.ahead_of({"a", 1}), 100);
  EXPECT_DOUBLE_EQ(queue.ahead_of({"b", 1}), 1) << "the tie goes to who came first";
  queue.add("b", 2);
  EXPECT_DOUBLE_EQ(queue.ahead_of({"b", 1}), 2 + 3);
  EXPECT_DOUBLE_EQ(queue.cost(), 102);
}

TEST(FairQueue, ATaskTakenOutLeavesTheOthersInOrder) {
  Queue queue;
  queue.add("a");
  queue.add("a");
  queue.add("b");
  EXPECT_EQ(queue.remove(1)->id, 1u);
  EXPECT_FALSE(queue.remove(1));
  EXPECT_EQ(queue.size(), 2u);
  EXPECT_EQ(queue.serve(), "ab");
}

TEST(FairQueue, ForgetsFlowsThatOweNothing) {
  Queue queue;
  for (int k = 0; k < 50; ++k) queue.add(std::to_string(k), 0);
  queue.serve();
  EXPECT_EQ(queue.flows(), 50u);
  queue.sweep(10);
  EXPECT_EQ(queue.flows(), 0u);
  queue.add("a", 10);
  queue.serve();
  queue.sweep(10);
  EXPECT_EQ(queue.flows(), 1u) << "it owes ten seconds";
  queue.idle();
  EXPECT_EQ(queue.flows(), 0u) << "the end of a busy period";
}

TEST(FairQueue, RemembersOnlySoManyFlowsThatCameOnceWithinABusyPeriod) {
  Queue queue;
  for (int k = 0; k < 50; ++k) queue.add(std::to_string(k), 1);
  queue.serve(48);
  queue.sweep(50);
  EXPECT_EQ(queue.flows(), 50u) << "each owes its second, and nobody's has begun after that";
  queue.sweep(10);
  EXPECT_EQ(queue.flows(), 2u) << "those that wait";
  EXPECT_EQ(queue.size(), 2u);
  EXPECT_EQ(queue.serve(), "4849");
}

}  // namespace
}  // namespace fracture
