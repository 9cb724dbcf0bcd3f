// Start-time fair queueing: the order of service, computed by hand from the tags of the paper.
#include "server/service/fair_queue.hpp"
#include "tests/server/service/polling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <random>

namespace fracture {
namespace {

struct Item {
  std::uint64_t id;
  double cost;
  Flow flow;
  std::chrono::steady_clock::time_point arrival{};
};

using test::kBackground, test::kBatch, test::kRealtime;

/// Serves one task after the other, and charges the stated cost.
struct Queue : FairQueue<Item> {
  std::uint64_t last = 0;
  std::uint64_t add(const std::string& flow, double cost = 1, double weight = 1, Priority priority = kBatch) {
    push(priority, {++last, cost, {flow, weight}});
    return last;
  }
  Next first() {
    return candidates([](const Client&, Priority) { return true; }).front();
  }
  Item pop() {
    const Next next = first();
    const Item item = take(next);
    charge(next.priority, item.flow, item.cost);
    advance(next.client->tag);
    end(*next.client);
    return item;
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
  EXPECT_EQ(queue.order(), (std::vector<std::uint64_t>{1, 2, 3}));
  for (std::uint64_t id = 1; id <= 3; ++id) EXPECT_EQ(queue.pop().id, id);
}

TEST(FairQueue, AFloodDelaysAnotherByOneTaskOnly) {
  Queue queue;
  for (int k = 0; k < 100; ++k) queue.add("a");
  EXPECT_EQ(queue.serve(10), std::string(10, 'a'));
  queue.add("b");
  queue.add("b");
  EXPECT_EQ(queue.serve(4), "baba");
}

TEST(FairQueue, WhoRestedGoesBeforeByTheCreditAndNoMore) {
  Queue queue;
  for (int k = 0; k < 100; ++k) queue.add("a", 0.1);
  queue.serve(50);
  for (int k = 0; k < 100; ++k) queue.add("b", 0.1);
  const std::string served = queue.serve(46);
  EXPECT_EQ(served.substr(0, 6), "bbbbbb") << "0.6 s";
  EXPECT_NEAR(std::count(served.begin(), served.end(), 'b'), 6 + 20, 1);
}

TEST(FairQueue, SharesAreByWeightAndByWhatTasksCost) {
  Queue queue;
  for (int k = 0; k < 900; ++k) queue.add("a", 0.1, 2);
  for (int k = 0; k < 900; ++k) queue.add("b", 0.1, 1);
  for (int k = 0; k < 900; ++k) queue.add("c", 0.3, 3);
  std::map<char, int> count;
  for (const char flow : queue.serve(800)) ++count[flow];
  EXPECT_NEAR(count['a'], 400, 4);  // twice the weight of b
  EXPECT_NEAR(count['b'], 200, 4);
  EXPECT_NEAR(count['c'], 200, 4);  // three times the weight, at three times the cost
}

TEST(FairQueue, BackgroundWorkGetsAFifthBesideWorkThatSomebodyWaitsFor) {
  Queue queue;
  for (int k = 0; k < 1000; ++k) queue.add("jobs", 0.1, 1, kBackground);
  for (int k = 0; k < 1000; ++k) queue.add("waits", 0.1, 1, kBatch);
  int jobs = 0;
  for (int k = 0; k < 1000; ++k) jobs += queue.pop().flow.name == "jobs";
  EXPECT_NEAR(jobs, 200, 5);
}

TEST(FairQueue, NoClientGetsMoreTimeByCallingItsWorkUrgent) {
  Queue queue;
  for (int k = 0; k < 1000; ++k) queue.add("urgent", 0.1, 1, kRealtime);
  for (int k = 0; k < 1000; ++k) queue.add("batch", 0.1, 1, kBatch);
  EXPECT_EQ(queue.serve(1), "urgent") << "it leads";
  int urgent = 0;
  for (int k = 0; k < 1000; ++k) urgent += queue.pop().flow.name == "urgent";
  EXPECT_NEAR(urgent, 500, 5);
}

TEST(FairQueue, TheFloodOfOneIsBehindTheRareTaskOfAnotherWhateverTheirClass) {
  Queue queue;
  for (int k = 0; k < 1000; ++k) queue.add("flood", 0.1, 1, kRealtime);
  queue.serve(100);
  for (int k = 0; k < 20; ++k) {
    queue.add("rare", 0.05, 1, kBackground);
    EXPECT_EQ(queue.serve(1), "rare") << k;
    queue.serve(10);
  }
}

TEST(FairQueue, WithinAClientTheMoreUrgentGoesFirst) {
  Queue queue;
  const std::uint64_t job = queue.add("a", 1, 1, kBackground), batch = queue.add("a"),
                      collision = queue.add("a", 1, 1, kRealtime);
  for (const std::uint64_t id : {collision, batch, job}) EXPECT_EQ(queue.pop().id, id);
}

TEST(FairQueue, WhoWaitedForAnothersTaskPaysToo) {
  Queue queue;
  for (int k = 0; k < 20; ++k) queue.add("a", 0.1);
  queue.pop();
  queue.charge(kBatch, {"b", 1}, 1);
  queue.add("b");
  EXPECT_EQ(queue.serve(11).find('b'), 10u) << "it owes a second, and had no credit left";
}

TEST(FairQueue, NobodyOwesMoreThanTheMost) {
  Queue queue;
  for (int k = 0; k < 100; ++k) queue.add("a", 0.1);
  queue.pop();
  queue.charge(kBatch, {"b", 1}, 1000);
  queue.add("b");
  EXPECT_NE(queue.serve(20).find('b'), std::string::npos);
}

TEST(FairQueue, TheOrderIsForetold) {
  std::mt19937 random(7);
  Queue queue;
  for (int k = 0; k < 200; ++k)
    queue.add(std::string(1, static_cast<char>('a' + random() % 5)), 0.01 * (1 + random() % 8));
  const std::vector<std::uint64_t> foretold = queue.order();
  for (const std::uint64_t id : foretold) ASSERT_EQ(queue.pop().id, id);
  EXPECT_TRUE(queue.empty());
}

TEST(FairQueue, WhatGoesBeforeANewTaskIsItsFlowsTurnAndNotTheWholeQueue) {
  Queue queue;
  const auto queued = [](const Queue::Client& client, Priority of) { return client.line(of).cost(); };
  const auto ahead = [&](const char* flow) { return queue.ahead_of(kBatch, {flow, 1}, 0, queued); };
  for (int k = 0; k < 200; ++k) queue.add("a", 0.1);
  EXPECT_NEAR(ahead("a"), 20, 1e-9);
  EXPECT_NEAR(ahead("b"), 0, 1e-9);
  queue.add("b", 2);
  EXPECT_NEAR(ahead("b"), 2 + 2, 1e-9) << "its own, and as much of the other's";
  EXPECT_NEAR(queue.ahead_of(kBatch, {"c", 1}, 0.5, queued), 2 * 0.5, 1e-9)
      << "as much of each, while it is computed";
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

TEST(FairQueue, AClientsNewestTaskIsTakenOut) {
  Queue queue;
  queue.add("a");
  queue.add("b");
  queue.add("a");
  EXPECT_EQ(queue.take_newest(queue.first()).id, 3u);
  EXPECT_EQ(queue.serve(), "ab");
}

TEST(FairQueue, ATaskThatAnotherWaitsForTakesTheSoonerTurn) {
  Queue queue;
  const auto as_expected = [](const Queue::Client&) { return 1.0; };
  for (int k = 0; k < 5; ++k) queue.add("a");
  EXPECT_FALSE(queue.hasten(1, {"b", 1}, as_expected)) << "the turns are equal";
  EXPECT_TRUE(queue.hasten(5, {"b", 1}, as_expected));
  EXPECT_EQ(queue.serve(2), "ab");
  queue.add("b");
  queue.add("b");
  EXPECT_FALSE(queue.hasten(2, {"b", 1}, as_expected));
  EXPECT_FALSE(queue.hasten(5, {"c", 1}, as_expected)) << "it is not queued any more";
  EXPECT_EQ(queue.size(), 5u);
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
  EXPECT_EQ(queue.flows(), 1u) << "it owes what is over its credit";
  queue.idle();
  EXPECT_EQ(queue.flows(), 0u) << "the end of a busy period";
}

TEST(FairQueue, RemembersOnlySoManyFlowsThatCameOnceWithinABusyPeriod) {
  Queue queue;
  for (int k = 0; k < 50; ++k) queue.add(std::to_string(k), 0.5);
  queue.serve(48);
  queue.sweep(50);
  EXPECT_EQ(queue.flows(), 50u) << "each owes its half second";
  queue.sweep(10);
  EXPECT_EQ(queue.flows(), 2u) << "those that wait";
  EXPECT_EQ(queue.size(), 2u);
}

}  // namespace
}  // namespace fracture
