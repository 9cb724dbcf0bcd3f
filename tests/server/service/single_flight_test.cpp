#include "server/service/single_flight.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

namespace fracture {
namespace {

using Flights = SingleFlight<int>;
using Role = Flights::Role;

TEST(SingleFlight, OneLeadsAndAllGetTheValueInTheOrderTheyCame) {
  Flights flights;
  std::string heard;
  const auto waiter = [&](char name) {
    return [&heard, name](const Expected<int>& v, Role role) {
      heard += name + std::to_string(*v) + (role == Role::kLeader ? "! " : " ");
    };
  };
  const auto a = flights.join("key", waiter('a')), b = flights.join("key", waiter('b'));
  EXPECT_EQ(a.role, Role::kLeader);
  EXPECT_EQ(b.role, Role::kFollower);
  EXPECT_EQ(flights.join("other", waiter('x')).role, Role::kLeader);
  flights.land(a.flight, 7);
  EXPECT_EQ(heard, "a7! b7 ");
  EXPECT_EQ(flights.join("key", waiter('c')).role, Role::kLeader) << "a flight that has landed is over";
}

TEST(SingleFlight, ItStopsWhenTheLastHasLeftAndNotBefore) {
  Flights flights;
  int called = 0;
  const auto count = [&](const Expected<int>&, Role) { ++called; };
  const auto leader = flights.join("key", count), second = flights.join("key", count);
  EXPECT_TRUE(flights.leave(leader));
  EXPECT_FALSE(leader.flight->stop().stop_requested());
  EXPECT_EQ(flights.join("key", count).role, Role::kFollower) << "the flight goes on without its leader";
  flights.land(leader.flight, 1);
  EXPECT_EQ(called, 2);
  EXPECT_FALSE(flights.leave(second)) << "too late";

  const auto lone = flights.join("key", count);
  EXPECT_TRUE(flights.leave(lone));
  EXPECT_FALSE(flights.leave(lone));
  EXPECT_TRUE(lone.flight->stop().stop_requested());
  EXPECT_EQ(flights.join("key", count).role, Role::kLeader) << "nobody joins a stopped flight";
  flights.land(lone.flight, 2);
  EXPECT_EQ(called, 2) << "who left is not called";
}

TEST(SingleFlight, EveryWaiterIsCalledOrHasLeftWhateverTheTiming) {
  Flights flights;
  std::atomic<int> called{0}, left{0}, led{0};
  constexpr int kThreads = 8, kRounds = 2000;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < kRounds; ++i) {
        const auto seat = flights.join("key", [&](const Expected<int>&, Role) { ++called; });
        if (seat.role == Role::kLeader) ++led;
        if ((i + t) % 3 == 0 && flights.leave(seat)) ++left;
        if (seat.role == Role::kLeader) flights.land(seat.flight, i);
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(called + left, kThreads * kRounds);
  EXPECT_GT(led, 0);
  EXPECT_EQ(flights.count(), 0u);
}

}  // namespace
}  // namespace fracture
