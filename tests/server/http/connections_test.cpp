// Which clients hold connections, and which connection is closed to make room.
#include "server/http/connections.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace fracture::http {
namespace {

using Verdict = Connections::Verdict;

/// A session that records how it is told to leave.
struct Seated final : Drainable {
  void close_when_idle() override {}
  void cancel_job() override {}
  void tokens_changed() override {}
  void give_way(Leave how) override { told = how; }
  using Drainable::set_waiting;
  std::optional<Leave> told;
};

struct Room : testing::Test {
  struct Guest {
    Verdict verdict;
    std::shared_ptr<Seated> session = std::make_shared<Seated>();
    Connections::Place place;
    bool is_told() const { return session->told.has_value(); }
  };
  Guest arrive(Connections& room, const std::string& client, bool busy = false) {
    Connections::Arrival arrival = room.add(client);
    Guest guest{arrival.verdict, std::make_shared<Seated>(), std::move(arrival.place)};
    if (guest.place) guest.place.enroll(guest.session);
    guest.session->set_waiting(!busy);
    return guest;
  }
};

TEST_F(Room, TheClientThatHasMostMakesRoomAndOfItsOwnTheLongestWaiting) {
  Connections room(20, 12);
  std::vector<Guest> others, many;
  for (int k = 0; k < 8; ++k) others.push_back(arrive(room, "b"));
  for (int k = 0; k < 12; ++k) many.push_back(arrive(room, "a", k == 0));
  many[1].session->set_waiting(true);  // starts waiting again, so others have waited longer
  const Guest newcomer = arrive(room, "c");
  EXPECT_EQ(newcomer.verdict, Verdict::kWelcome);
  EXPECT_EQ(many[2].session->told, Drainable::Leave::kIfItWaits);
  std::size_t told = 0;
  for (const auto* guests : {&others, &many})
    for (const Guest& guest : *guests) told += guest.is_told();
  EXPECT_EQ(told, 1u);
  EXPECT_EQ(room.count(), 21u) << "until it is closed";
}

/// A client that uses its two connections does not make room while a client with a single one is idle.
TEST_F(Room, OfClientsWithFewTheLongestWaitingGoes) {
  Connections room(4, 4);
  const Guest a = arrive(room, "a"), idle = arrive(room, "b"), c = arrive(room, "a"), d = arrive(room, "c");
  a.session->set_waiting(true);
  const Guest newcomer = arrive(room, "d");
  EXPECT_TRUE(idle.is_told());
  EXPECT_FALSE(a.is_told() || c.is_told() || d.is_told());
}

TEST_F(Room, NobodyMakesRoomForAClientThatHasMoreNorTheClientItself) {
  Connections room(12, 12);
  std::vector<Guest> many;
  for (int k = 0; k < 9; ++k) many.push_back(arrive(room, "a", true));
  const Guest b = arrive(room, "b"), c = arrive(room, "b"), d = arrive(room, "c", true);
  EXPECT_EQ(arrive(room, "a").verdict, Verdict::kFull);
  EXPECT_EQ(arrive(room, "b").verdict, Verdict::kWelcome) << "a is busy, and has more than it then has";
  EXPECT_TRUE(many.back().is_told());
  EXPECT_FALSE(b.is_told() || c.is_told() || d.is_told());
  Connections small(2, 2);
  const Guest busy = arrive(small, "a", true), own = arrive(small, "b");
  EXPECT_EQ(arrive(small, "b").verdict, Verdict::kFull);
  EXPECT_FALSE(busy.is_told() || own.is_told());
}

TEST_F(Room, WhatManyClientsShareMakesRoomForItself) {
  Connections room(2, 1);
  std::vector<Guest> all;
  for (int k = 0; k < 5; ++k) {
    Connections::Arrival arrival = room.add("proxy", Connections::OfClient::kUnlimited);
    all.push_back({arrival.verdict, std::make_shared<Seated>(), std::move(arrival.place)});
    ASSERT_EQ(all.back().verdict, Verdict::kWelcome) << k;
    all.back().place.enroll(all.back().session);
    if (k >= 2) {
      EXPECT_TRUE(all[static_cast<std::size_t>(k) - 2].is_told());
    }
  }
}

TEST_F(Room, WhatIsBeingComputedIsGivenUpOnlyForAClientThatWillHaveFewer) {
  Connections room(3, 3);
  const Guest a = arrive(room, "a", true), b = arrive(room, "a", true), c = arrive(room, "b", true);
  EXPECT_EQ(arrive(room, "b").verdict, Verdict::kFull) << "it would have as many";
  const Guest newcomer = arrive(room, "c", true);
  EXPECT_EQ(newcomer.verdict, Verdict::kWelcome);
  EXPECT_EQ(b.session->told, Drainable::Leave::kAnyhow) << "the latest of those that are busy";
  EXPECT_FALSE(a.is_told() || c.is_told());
  EXPECT_EQ(arrive(room, "d").verdict, Verdict::kFull) << "each has one";
}

/// However many clients hold one connection each, the next client is served.
TEST_F(Room, OfManyThatHaveOneTheLongestWaitingGoes) {
  Connections room(8, 2);
  std::vector<Guest> many;
  for (int client = 0; client < 8 + 8; ++client) {
    many.push_back(arrive(room, "client " + std::to_string(client)));
    ASSERT_EQ(many.back().verdict, Verdict::kWelcome) << client;
    if (client >= 8) {
      EXPECT_TRUE(many[client - 8].is_told());
    }
  }
}

TEST_F(Room, RefusedOnesTakeNoPlacesAndFewOfThemAreTold) {
  Connections room(100, 2);
  std::vector<Guest> refused;
  const Guest first = arrive(room, "a"), second = arrive(room, "a");
  for (int k = 0; k < 1000; ++k) refused.push_back(arrive(room, "a"));
  std::size_t told = 0;
  for (const Guest& guest : refused) {
    EXPECT_EQ(guest.verdict, Verdict::kTooManyOfClient);
    told += static_cast<bool>(guest.place);
  }
  EXPECT_EQ(told, Connections::kMostToldOfClient);
  EXPECT_EQ(room.count(), 2 + told);
  for (int client = 0; client < 20; ++client)
    for (int k = 0; k < 10; ++k) refused.push_back(arrive(room, "client " + std::to_string(client)));
  EXPECT_EQ(room.count(), 2 + 2 * 20 + Connections::kMostTold);
  EXPECT_EQ(arrive(room, "b").verdict, Verdict::kWelcome);
  refused.clear();
  EXPECT_EQ(room.count(), 2u);
  EXPECT_TRUE(arrive(room, "a").place) << "it is told again";
}

TEST_F(Room, WhoLeavesIsWaitedForUpToANumber) {
  Connections room(1, 1);
  std::vector<Guest> all;
  for (std::size_t k = 0; k <= Connections::kMostLeaving; ++k) {
    all.push_back(arrive(room, "client " + std::to_string(k)));
    EXPECT_EQ(all.back().verdict, Verdict::kWelcome) << k;
  }
  EXPECT_EQ(arrive(room, "another").verdict, Verdict::kFull);
  all.front().place = {};
  EXPECT_EQ(arrive(room, "another").verdict, Verdict::kWelcome);
}

TEST_F(Room, AConnectionOfAProxyIsTheClientsForWhomItAsks) {
  using OfClient = Connections::OfClient;
  Connections room(8, 2);
  std::vector<Connections::Place> of_proxy;
  for (int k = 0; k < 4; ++k) of_proxy.push_back(room.add("proxy", OfClient::kUnlimited).place);
  EXPECT_TRUE(of_proxy[0].belongs_to("a", OfClient::kLimited));
  EXPECT_TRUE(of_proxy[1].belongs_to("a", OfClient::kLimited));
  EXPECT_FALSE(of_proxy[2].belongs_to("a", OfClient::kLimited));
  EXPECT_TRUE(of_proxy[2].belongs_to("b", OfClient::kLimited));
  EXPECT_TRUE(of_proxy[1].belongs_to("proxy", OfClient::kUnlimited));
  EXPECT_TRUE(of_proxy[3].belongs_to("a", OfClient::kLimited));
  EXPECT_EQ(room.add("a").verdict, Verdict::kTooManyOfClient);
  of_proxy.clear();
  EXPECT_EQ(room.count(), 0u);
  EXPECT_EQ(room.add("a").verdict, Verdict::kWelcome);
}

}  // namespace
}  // namespace fracture::http
