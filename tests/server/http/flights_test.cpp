// Many clients at once: shared computations, priority classes, deadlines, refusals.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tests/server/support/gate.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

struct FlightsOverHttp : testing::Test {
  TestServer server;
  Gate gate;
  std::vector<std::unique_ptr<RawClient>> clients;

  void SetUp() override { server.control->during_cut = gate.hook(); }
  void TearDown() override { gate.open = true; }
  RawClient& send(const std::string& target, const std::string& fields = "") {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    clients.back()->send("POST " + target + " HTTP/1.1\r\nHost: t\r\nContent-Type: model/gltf-binary\r\n" +
                         fields + "Content-Length: 4\r\n\r\nmesh");
    return *clients.back();
  }
  void wait_for_waiters(std::uint64_t collapsed) {
    require_eventually(kPatience, "equal requests to be one",
                       [&] { return server.dispatcher.figures().collapsed >= collapsed; });
  }
};

TEST_F(FlightsOverHttp, SixtyFourIdenticalColdRequestsAreOneComputation) {
  for (int i = 0; i < 64; ++i) send("/fracture");
  wait_for_waiters(63);
  gate.open = true;
  int collapsed = 0;
  std::string body;
  for (const auto& client : clients) {
    const auto reply = client->receive();
    ASSERT_TRUE(reply && reply->status == 200);
    if (body.empty()) body = reply->body;
    EXPECT_EQ(reply->body, body);
    collapsed += reply->header("cache-status").find("collapsed") != std::string::npos;
  }
  EXPECT_EQ(collapsed, 63);
  EXPECT_EQ(server.control->imports, 1);
  EXPECT_EQ(server.control->cuts, 1);
}

TEST_F(FlightsOverHttp, TheLeaderIsResetHalfWayAndTheOthersGetTheirAnswer) {
  RawClient& leader = send("/fracture");
  require_eventually(kPatience, "a computation to come to the gate", [&] { return gate.arrived > 0; });
  for (int i = 0; i < 63; ++i) send("/fracture");
  wait_for_waiters(63);
  leader.reset();
  require_eventually(kPatience, "the reset to be seen",
                     [&] { return server.dispatcher.figures().abandoned > 0; });
  gate.open = true;
  for (std::size_t i = 1; i < clients.size(); ++i) {
    const auto reply = clients[i]->receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, 200);
  }
  EXPECT_EQ(server.control->cuts, 1);
  EXPECT_EQ(server.control->cancelled, 0);
}

TEST_F(FlightsOverHttp, WhenEveryClientIsResetTheComputationStops) {
  for (int i = 0; i < 10; ++i) send("/fracture");
  wait_for_waiters(9);
  require_eventually(kPatience, "a computation to come to the gate", [&] { return gate.arrived > 0; });
  for (const auto& client : clients) client->reset();
  server.dispatcher.wait_idle();  // although the gate stays closed
  EXPECT_EQ(server.control->cancelled, 1);
  require_eventually(kPatience, "all to be counted as abandoned",
                     [&] { return server.dispatcher.figures().abandoned == 10u; });
}

// Urgent data wakes the code that watches for a reset. It is not a reset, so the watch goes on.
TEST_F(FlightsOverHttp, AResetAfterUrgentBytesIsSeenToo) {
  TestServerOptions options;
  options.server.io_threads = 1;  // so that events are handled in their order
  TestServer other(options);
  other.control->during_cut = server.control->during_cut;
  RawClient client(other.port());
  client.send(
      "POST /fracture HTTP/1.1\r\nHost: t\r\nContent-Type: model/gltf-binary\r\nContent-Length: 4\r\n\r\nmesh");
  require_eventually(kPatience, "a computation to come to the gate", [&] { return gate.arrived > 0; });
  for (int k = 0; k < 2; ++k) {
    ASSERT_TRUE(client.send_urgent('!'));
    EXPECT_EQ(other.get("/version").status, 200) << "the urgent byte before it was looked at";
  }
  EXPECT_EQ(other.dispatcher.figures().abandoned, 0u) << "urgent data is no reset";
  client.reset();
  EXPECT_TRUE(eventually(kPatience, "the reset to be seen",
                         [&] { return other.dispatcher.figures().abandoned == 1; }));
  gate.open = true;
  other.dispatcher.wait_idle();
}

TEST_F(FlightsOverHttp, RequestTimeoutLowersTheDeadlineOfOneWaiterOnly) {
  send("/fracture");
  RawClient& hasty = send("/fracture", "Request-Timeout: 0.05\r\n");
  const auto late = hasty.receive();
  ASSERT_TRUE(late);
  EXPECT_EQ(late->status, 504);
  EXPECT_EQ(late->problem(), "deadline-exceeded");
  gate.open = true;
  EXPECT_EQ(clients[0]->receive()->status, 200);
}

/// The answer exists. A client for which it cannot be compressed in time gets it uncompressed.
TEST_F(FlightsOverHttp, WhoWaitsForACompressionWaitsForAsLongAsItMay) {
  gate.open = true;
  server.control->glb_padding = 1u << 20;
  const std::string target = server.post("/fracture").header("content-location");
  gate.open = false;
  gate.arrived = 0;
  server.control->during_cut = gate.hook_without_polls();
  for (const char* sites : {"5", "6"}) send(std::string("/fracture?sites=") + sites);
  gate.wait_for(2);  // one for each thread
  const auto get = [&](const std::string& fields) -> RawClient& {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    clients.back()->send("GET " + target + " HTTP/1.1\r\nHost: t\r\nAccept-Encoding: gzip\r\n" + fields +
                         "\r\n");
    return *clients.back();
  };
  RawClient& hasty = get("Request-Timeout: 0.1\r\n");
  RawClient& patient = get("");
  RawClient& hasty_too = get("Request-Timeout: 0.1\r\n");
  for (RawClient* const client : {&hasty, &hasty_too}) {
    const auto reply = client->receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, 200);
    EXPECT_EQ(reply->header("content-encoding"), "");
  }
  gate.open = true;
  const auto reply = patient.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->header("content-encoding"), "gzip") << "whoever leaves, it is made for the others";
}

TEST_F(FlightsOverHttp, ARequestTimeoutThatIsNoTimeIsRefused) {
  for (const char* value : {"0", "-1", "soon", "1s", "nan", "1e9"})
    EXPECT_EQ(server
                  .post("/fracture", "mesh",
                        std::string("Content-Type: model/gltf-binary\r\nRequest-Timeout: ") + value + "\r\n")
                  .problem(),
              "bad-parameter")
        << value;
}

TEST_F(FlightsOverHttp, TheDeadlineOfRealtimeWorkIsTheShortOne) {
  TestServerOptions options;
  options.limits.realtime_deadline = std::chrono::milliseconds(100);
  TestServer other(options);
  other.control->during_cut = server.control->during_cut;
  const auto urgent = [&](const char* priority) {
    return ask(other.port(), "POST", "/fracture",
               std::string("Content-Type: model/gltf-binary\r\nPriority: ") + priority + "\r\n", "mesh");
  };
  EXPECT_EQ(urgent("u=1").problem(), "deadline-exceeded");
  EXPECT_EQ(urgent("i, u=2;x").problem(), "deadline-exceeded");
  other.dispatcher.wait_idle();
  gate.open = true;
  EXPECT_EQ(urgent("u=1").status, 200);
}

TEST_F(FlightsOverHttp, WhatCannotBeInTimeIsRefusedAtOnceWithAComputedRetryAfter) {
  for (int i = 0; i < 200; ++i) server.pool.measured("address 127.0.0.1", 1, 1e5);  // very slow
  send("/fracture?seed=1");
  send("/fracture?seed=2");
  require_eventually(kPatience, "two computations to come to the gate", [&] { return gate.arrived >= 2; });
  const Reply refused = server.post("/fracture?seed=3");
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.problem(), "overloaded");
  EXPECT_GE(std::stoi(refused.header("retry-after")), 1);
  EXPECT_EQ(server.control->cuts, 2);
  EXPECT_EQ(server.get("/version").status, 200);
  // A large body is refused before it is sent.
  RawClient large(server.port());
  large.send(
      "POST /fracture?seed=4 HTTP/1.1\r\nHost: t\r\nContent-Type: model/stl\r\nExpect: 100-continue\r\n"
      "Content-Length: 1000000\r\n\r\n");
  EXPECT_EQ(large.receive()->status, 503);
  gate.open = true;
  for (const auto& client : clients) EXPECT_EQ(client->receive()->status, 200);
}

}  // namespace
}  // namespace fracture::test
