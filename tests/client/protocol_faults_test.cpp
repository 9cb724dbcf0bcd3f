// Servers that are silent or absent or die, and requests that are cancelled.
#include <optional>
#include <set>

#include "tests/client/protocol_fixture.hpp"

namespace fracture::protocol {
namespace {

TEST(ProtocolClient, ASilentServerTimesOut) {
  FakeServer server([](const FakeRequest&) { return FakeReply{"", false, true}; });
  Settings s = settings(server.port());
  s.answer_timeout = Milliseconds(20);
  s.patience = Milliseconds(50);
  Client client(s);
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.failure, Failure::kTimedOut);
  EXPECT_GE(answer.exchanges, 1);
}

TEST(ProtocolClient, CancelledRequestsSaySo) {
  FakeServer server([](const FakeRequest&) { return FakeReply{"", false, true}; });
  Settings s = settings(server.port());
  s.connections = 1;  // the second request waits for the connection of the first
  Client client(s);
  const Ticket first = client.fracture("sha256:0", {}), second = client.fracture("sha256:0", {});
  client.cancel(second);
  client.cancel(first);
  client.cancel(12345);
  std::set<Ticket> cancelled;
  for (const Answer& answer : wait_for(client, 2)) {
    EXPECT_EQ(answer.failure, Failure::kCancelled);
    cancelled.insert(answer.ticket);
  }
  EXPECT_EQ(cancelled, (std::set<Ticket>{first, second}));
}

TEST(ProtocolClient, WhatIsTakenBackIsClosedSoThatTheServerStops) {
  FakeServer server([](const FakeRequest&) { return FakeReply{"", false, true}; });
  Client client(settings(server.port()));
  const Ticket ticket = client.fracture("sha256:0", {});
  ASSERT_TRUE(
      test::eventually(test::kPatience, "the request", [&] { return server.requests().size() == 1; }));
  client.cancel(ticket);
  EXPECT_EQ(wait_for_one(client).failure, Failure::kCancelled);
  EXPECT_TRUE(test::eventually(test::kPatience, "the close", [&] { return server.closes() == 1; }));
}

TEST(ProtocolClient, TheClientEndsWhileRequestsAreOpen) {
  FakeServer server([](const FakeRequest&) { return FakeReply{"", false, true}; });
  Settings s = settings(server.port());
  s.connections = 2;
  Client client(s);
  for (int k = 0; k < 10; ++k) client.fracture("sha256:0", {});
  test::require_eventually(test::kPatience, "two requests", [&] { return server.requests().size() >= 2; });
}

/// A port on which nobody listens: it belonged to a server that no longer exists.
std::uint16_t deserted_port() {
  FakeServer server([](const FakeRequest&) { return fragments(); });
  return server.port();
}

TEST(ProtocolClient, AnAbsentServerIsAFailureWhenThePatienceEnds) {
  Settings s = settings(deserted_port());
  s.patience = Milliseconds(20);
  Client client(s);
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.failure, Failure::kServerAbsent);
  EXPECT_EQ(answer.status, 0);
  EXPECT_FALSE(answer.detail.empty());
  EXPECT_EQ(client.status().state, ServerState::kAbsent);
}

TEST(ProtocolClient, ARequestWaitsForTheServerToComeBack) {
  const std::uint16_t port = deserted_port();
  Client client(settings(port));
  client.fracture("sha256:0", {});
  test::require_eventually(test::kPatience, "three tries", [&] { return client.status().retried >= 3; });
  EXPECT_TRUE(client.poll().empty());
  FakeServer server([](const FakeRequest&) { return fragments(); }, port);
  EXPECT_TRUE(wait_for_one(client).ok());
  EXPECT_EQ(client.status().state, ServerState::kReachable);
}

TEST(ProtocolClient, AServerThatDiesInMidFlightAndComesBackAnswers) {
  std::optional<FakeServer> server;
  std::atomic<bool> asked = false;
  server.emplace([&](const FakeRequest&) {
    asked = true;
    return FakeReply{"", false, true};
  });
  const std::uint16_t port = server->port();
  Client client(settings(port));
  client.fracture("sha256:0", {});
  test::require_eventually(test::kPatience, "the first request", [&] { return asked.load(); });
  server.reset();
  server.emplace([](const FakeRequest&) { return fragments(); }, port);
  const Answer answer = wait_for_one(client);
  EXPECT_TRUE(answer.ok()) << answer.detail;
  EXPECT_GE(answer.exchanges, 2);
}

TEST(ProtocolClient, AKeptConnectionThatTheServerClosedIsReplacedUnseen) {
  FakeServer server([](const FakeRequest& request) {
    FakeReply reply = fragments();
    reply.close = request.number == 0;  // without announcing Connection: close
    return reply;
  });
  Client client(settings(server.port()));
  client.fracture("sha256:0", {});
  EXPECT_TRUE(wait_for_one(client).ok());
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  EXPECT_TRUE(answer.ok()) << answer.detail;
  EXPECT_EQ(answer.exchanges, 1);
  EXPECT_EQ(server.connections(), 2);
}

TEST(ProtocolClient, TheHeartbeatNoticesAServerThatComes) {
  const std::uint16_t port = deserted_port();
  Settings s = settings(port);
  s.heartbeat = Milliseconds(5);
  Client client(s);
  test::require_eventually(test::kPatience, "the client to see that nobody is there",
                           [&] { return client.status().state == ServerState::kAbsent; });
  FakeServer server([](const FakeRequest&) { return FakeReply::answer(200, "{}"); }, port);
  test::require_eventually(test::kPatience, "the client to see the server",
                           [&] { return client.status().state == ServerState::kReachable; });
  EXPECT_EQ(server.requests().front().target, "/version");
}

}  // namespace
}  // namespace fracture::protocol
