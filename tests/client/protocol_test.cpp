// Meshes are stored once, fractures requested, refusals understood.
#include <set>

#include "tests/client/protocol_fixture.hpp"

namespace fracture::protocol {
namespace {

TEST(ProtocolClient, StoresByDigestThenFractures) {
  FakeServer server([](const FakeRequest& request) {
    return request.method == "PUT" ? stored() : fragments("Server-Timing: work;dur=3.5\r\n");
  });
  Client client(settings(server.port()));
  Ticket put = 0;
  const std::string id = client.add_mesh("mesh", "model/gltf-binary", "material=glass", &put);
  EXPECT_EQ(id, mesh_id("mesh"));
  const Answer first = wait_for_one(client);
  EXPECT_EQ(first.ticket, put);
  EXPECT_EQ(first.kind, RequestKind::kStore);
  EXPECT_TRUE(first.ok()) << first.detail;
  const Ticket broken = client.fracture(id, {{"sites", 7}});
  const Answer second = wait_for_one(client);
  EXPECT_EQ(second.ticket, broken);
  ASSERT_TRUE(second.ok()) << second.detail;
  EXPECT_EQ(second.body, kFragments);
  ASSERT_EQ(second.server_timing.size(), 1u);
  EXPECT_EQ(second.server_timing[0].milliseconds, 3.5);
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].method, "PUT");
  EXPECT_EQ(requests[0].target, "/meshes/" + id + "?material=glass");
  EXPECT_EQ(requests[0].body, "mesh");
  EXPECT_EQ(requests[1].method, "POST");
  EXPECT_EQ(requests[1].target, "/meshes/" + id + "/fracture");
  EXPECT_EQ(requests[1].body, R"({"sites":7})");
  const Status status = client.status();
  EXPECT_EQ(status.state, ServerState::kReachable);
  EXPECT_EQ(status.answered, 2u);
  EXPECT_EQ(status.failed, 0u);
  EXPECT_EQ(status.open, 0u);
  EXPECT_EQ(status.meshes_stored, 1u);
  EXPECT_EQ(status.fractures_timed, 1u);
  EXPECT_EQ(status.p50_ms, second.milliseconds);
  EXPECT_EQ(status.p99_ms, second.milliseconds);
}

TEST(ProtocolClient, RequestsOneAfterAnotherShareAConnection) {
  FakeServer server([](const FakeRequest&) { return fragments(); });
  Client client(settings(server.port()));
  for (int k = 0; k < 5; ++k) {
    client.fracture("sha256:0", {});
    EXPECT_TRUE(wait_for_one(client).ok());
  }
  EXPECT_EQ(server.connections(), 1);
}

TEST(ProtocolClient, AtMostSoManyConnectionsAtOnce) {
  FakeServer server([](const FakeRequest&) { return fragments(); });
  Settings s = settings(server.port());
  s.connections = 2;
  Client client(s);
  for (int k = 0; k < 20; ++k) client.fracture("sha256:0", {{"seed", k}});
  std::set<Ticket> tickets;
  for (const Answer& answer : wait_for(client, 20)) {
    EXPECT_TRUE(answer.ok()) << answer.detail;
    tickets.insert(answer.ticket);
  }
  EXPECT_EQ(tickets.size(), 20u);
  EXPECT_LE(server.connections(), 2);
}

TEST(ProtocolClient, ForgottenMeshIsPutAndAskedForAgain) {
  std::atomic<bool> known = false;
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") known = true;
    if (request.method == "PUT") return stored();
    return known ? fragments() : problem(404, "not-found");
  });
  Client client(settings(server.port()));
  const std::string id = client.add_mesh("mesh", "model/obj");
  wait_for_one(client);
  known = false;  // as after a restart of the server
  client.fracture(id, {});
  const Answer answer = wait_for_one(client);
  ASSERT_TRUE(answer.ok()) << answer.detail;
  EXPECT_EQ(answer.exchanges, 3);  // POST, PUT, POST
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 4u);
  EXPECT_EQ(requests[2].method, "PUT");
  EXPECT_EQ(requests[2].body, "mesh");
}

TEST(ProtocolClient, ManyRequestsForAForgottenMeshPutItOnce) {
  std::atomic<bool> known = true;
  std::atomic<int> refused = 0;
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") {
      // The first PUT comes at the start; the second comes when all four requests have been refused.
      test::require_eventually(test::kPatience, "four refusals", [&] { return known || refused == 4; });
      known = true;
      return stored();
    }
    if (known) return fragments();
    ++refused;
    return problem(404, "not-found");
  });
  Settings s = settings(server.port());
  s.connections = 8;
  Client client(s);
  const std::string id = client.add_mesh("mesh", "model/obj");
  wait_for_one(client);
  known = false;
  for (int k = 0; k < 4; ++k) client.fracture(id, {{"seed", k}});
  for (const Answer& answer : wait_for(client, 4)) EXPECT_TRUE(answer.ok()) << answer.detail;
  int puts = 0;
  for (const FakeRequest& request : server.requests()) puts += request.method == "PUT";
  EXPECT_EQ(puts, 2);
}

TEST(ProtocolClient, AFragmentThatDoesNotExistIsNoForgottenMesh) {
  FakeServer server([](const FakeRequest& request) {
    return request.method == "PUT" ? stored() : problem(404, "no-such-fragment");
  });
  Client client(settings(server.port()));
  const std::string id = client.add_mesh("mesh", "model/obj");
  wait_for_one(client);
  client.fracture(id, {{"fragment", 3}});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.failure, Failure::kRefused);
  EXPECT_EQ(answer.problem, "no-such-fragment");
  EXPECT_EQ(server.requests().size(), 2u);
}

TEST(ProtocolClient, AnUnknownMeshIsRefusedOnce) {
  FakeServer server([](const FakeRequest&) { return problem(404, "not-found"); });
  Client client(settings(server.port()));
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.failure, Failure::kRefused);
  EXPECT_EQ(answer.status, 404);
  EXPECT_EQ(server.requests().size(), 1u);
}

TEST(ProtocolClient, RefusalsCarryTheServersWords) {
  FakeServer server([](const FakeRequest&) { return problem(400, "bad-parameter"); });
  Client client(settings(server.port()));
  client.fracture("sha256:0", {{"sites", -1}});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.failure, Failure::kRefused);
  EXPECT_EQ(answer.problem, "bad-parameter");
  EXPECT_EQ(answer.detail, "Because.");
  EXPECT_EQ(client.status().state, ServerState::kReachable);
}

TEST(ProtocolClient, ABusyServerIsAskedAgainAfterItsRetryAfter) {
  FakeServer server([](const FakeRequest& request) {
    return request.number < 6 ? problem(503, "overloaded", "Retry-After: 0\r\n") : fragments();
  });
  Client client(settings(server.port()));
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  EXPECT_TRUE(answer.ok()) << answer.detail;
  EXPECT_EQ(answer.exchanges, 7);
  EXPECT_EQ(client.status().retried, 6u);
  EXPECT_EQ(server.connections(), 1);
}

TEST(ProtocolClient, ARetryAfterBeyondThePatienceIsAnAnswerAtOnce) {
  FakeServer server([](const FakeRequest&) { return problem(503, "overloaded", "Retry-After: 3600\r\n"); });
  Client client(settings(server.port()));
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.failure, Failure::kOverloaded);
  EXPECT_EQ(answer.exchanges, 1);
  EXPECT_EQ(client.status().state, ServerState::kOverloaded);
}

TEST(ProtocolClient, AStormOfRefusalsLosesNoRequest) {
  FakeServer server([](const FakeRequest& request) {
    return request.number % 3 != 2 ? problem(503, "overloaded", "Retry-After: 0\r\n") : fragments();
  });
  Client client(settings(server.port()));
  for (int k = 0; k < 50; ++k) client.fracture("sha256:0", {{"seed", k}});
  for (const Answer& answer : wait_for(client, 50)) EXPECT_TRUE(answer.ok()) << answer.detail;
  EXPECT_EQ(server.requests().size(), 150u);
}

TEST(ProtocolClient, PatternsAreJsonOrDamaged) {
  FakeServer server([](const FakeRequest& request) {
    return FakeReply::answer(200, request.number == 0 ? "{\"patterns\": [" : R"({"patterns": []})");
  });
  Client client(settings(server.port()));
  const Ticket ticket = client.patterns();
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.ticket, ticket);
  EXPECT_EQ(answer.kind, RequestKind::kPatterns);
  ASSERT_TRUE(answer.ok()) << answer.detail;
  EXPECT_EQ(answer.body, R"({"patterns": []})");
  EXPECT_EQ(answer.exchanges, 2);
}

TEST(ProtocolClient, TheTokenIsSent) {
  FakeServer server([](const FakeRequest&) { return FakeReply::answer(200, "{}"); });
  Settings s = settings(server.port());
  s.token = "secret";
  Client client(s);
  client.patterns();
  wait_for_one(client);
  EXPECT_NE(server.requests().front().head.find("Authorization: Bearer secret\r\n"), std::string::npos);
}

}  // namespace
}  // namespace fracture::protocol
