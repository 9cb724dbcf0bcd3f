#include "client/protocol/client.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "common/exchange/headers.hpp"
#include "tests/client/fake_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::protocol {
namespace {

using test::FakeReply;
using test::FakeRequest;
using test::FakeServer;

const std::string kFragments = "glTF: pretended fragments";
// printf 'glTF: pretended fragments' | openssl dgst -sha256 -binary | base64
const std::string kDigest = "Repr-Digest: sha-256=:G85sfc2HGlq0xr5AGgYU4JG0eDOCIaTZo6vESsOur54=:\r\n";

FakeReply fragments(const std::string& more = "") {
  return FakeReply::answer(200, kFragments, kDigest + more);
}
FakeReply problem(int status, const std::string& slug, const std::string& headers = "") {
  return FakeReply::answer(status, R"({"type": "/problems/)" + slug + R"(", "detail": "Because."})",
                           "Content-Type: application/problem+json\r\n" + headers);
}
FakeReply stored() { return FakeReply::answer(201, "{}"); }

/// Without a heartbeat, so that the fake server sees what the test asks for and nothing else.
Settings settings(std::uint16_t port) {
  Settings s;
  s.port = port;
  s.heartbeat = Milliseconds(0);
  s.first_pause = Milliseconds(1);
  s.longest_pause = Milliseconds(10);
  return s;
}

/// The next `count` answers.
std::vector<Answer> wait_for(Client& client, std::size_t count) {
  std::vector<Answer> all;
  test::require_eventually(test::kPatience, std::to_string(count) + " answers", [&] {
    for (Answer& answer : client.poll()) all.push_back(std::move(answer));
    return all.size() >= count;
  });
  return all;
}
Answer wait_for_one(Client& client) { return wait_for(client, 1).front(); }

// -- the fields, as values

TEST(ProtocolHeaders, ServerTimingIsReadAndNonsenseLeftOut) {
  const auto stages =
      parse_server_timing("queue;dur=0.5, clip;desc=\"x\";dur=12 , odd, bad;dur=1x, gone;dur=-1");
  ASSERT_EQ(stages.size(), 2u);
  EXPECT_EQ(stages[0].name, "queue");
  EXPECT_EQ(stages[0].milliseconds, 0.5);
  EXPECT_EQ(stages[1].name, "clip");
  EXPECT_EQ(stages[1].milliseconds, 12);
  EXPECT_TRUE(parse_server_timing("").empty());
}

TEST(ProtocolHeaders, RetryAfterIsSecondsWithinADay) {
  EXPECT_EQ(parse_retry_after("2"), Milliseconds(2000));
  EXPECT_EQ(parse_retry_after(" 0 "), Milliseconds(0));
  for (const char* text : {"", "-1", "1.5", "Fri, 31 Dec 1999 23:59:59 GMT", "99999999999999999999", "86401"})
    EXPECT_FALSE(parse_retry_after(text)) << text;
}

TEST(ProtocolHeaders, DigestIsThatOfTheBytes) {
  // The digest of nothing is known from FIPS 180-4's examples; its base64 from coreutils.
  const std::string of_nothing = "sha-256=:47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=:";
  EXPECT_TRUE(digest_matches(of_nothing, ""));
  EXPECT_TRUE(digest_matches("md5=:x:, " + of_nothing, ""));
  EXPECT_FALSE(digest_matches(of_nothing, "x"));
  EXPECT_FALSE(digest_matches("md5=:x:", ""));
  EXPECT_EQ(mesh_id(""), "sha256:e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

// -- conversations

TEST(ProtocolClient, StoresByDigestThenFractures) {
  FakeServer server([](const FakeRequest& request) {
    return request.method == "PUT" ? stored() : fragments("Server-Timing: work;dur=3.5\r\n");
  });
  Client client(settings(server.port()));
  Ticket put = 0;
  const std::string id = client.add_mesh("mesh", "model/gltf-binary", &put);
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
  EXPECT_EQ(requests[0].target, "/meshes/" + id);
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
      // The first is the start's; the second comes when all four have been refused.
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

TEST(ProtocolClient, ABitThatFlippedIsNoticedAndAskedForAgain) {
  FakeServer server([](const FakeRequest& request) {
    FakeReply reply = fragments();
    if (request.number == 0) reply.bytes.back() ^= 4;
    return reply;
  });
  Client client(settings(server.port()));
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  ASSERT_TRUE(answer.ok()) << answer.detail;
  EXPECT_EQ(answer.body, kFragments);
  EXPECT_EQ(answer.exchanges, 2);
}

TEST(ProtocolClient, AnswersThatStayDamagedFailAsDamaged) {
  FakeServer server([](const FakeRequest&) { return FakeReply::answer(200, "other bytes", kDigest); });
  Client client(settings(server.port()));
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.failure, Failure::kDamaged);
  EXPECT_TRUE(answer.body.empty());
  EXPECT_EQ(answer.exchanges, 3);
}

TEST(ProtocolClient, AnAnswerWithoutDigestIsDamaged) {
  FakeServer server([](const FakeRequest&) { return FakeReply::answer(200, kFragments); });
  Client client(settings(server.port()));
  client.fracture("sha256:0", {});
  EXPECT_EQ(wait_for_one(client).failure, Failure::kDamaged);
}

TEST(ProtocolClient, EveryTruncationOfAnAnswerIsSurvived) {
  const std::string whole = fragments().bytes;
  std::atomic<std::size_t> length = 0;
  std::atomic<bool> cut = true;
  FakeServer server([&](const FakeRequest&) {
    if (!cut.exchange(false)) return FakeReply{whole};
    return FakeReply{whole.substr(0, length), true};
  });
  Client client(settings(server.port()));
  for (length = 1; length < whole.size(); ++length) {
    cut = true;
    client.fracture("sha256:0", {});
    const Answer answer = wait_for_one(client);
    ASSERT_TRUE(answer.ok()) << length.load() << ": " << answer.detail;
    EXPECT_EQ(answer.body, kFragments);
  }
}

TEST(ProtocolClient, EveryFlippedByteOfAnAnswerIsSurvived) {
  const std::string whole = fragments().bytes;
  std::atomic<std::size_t> at = 0;
  std::atomic<bool> flip = true;
  FakeServer server([&](const FakeRequest&) {
    FakeReply reply{whole};
    if (flip.exchange(false)) {
      reply.bytes[at] = static_cast<char>(reply.bytes[at] ^ 0x12);
      reply.close = true;  // a length that grew would be waited for
    }
    return reply;
  });
  Client client(settings(server.port()));
  for (at = 0; at < whole.size(); ++at) {
    flip = true;
    client.fracture("sha256:0", {});
    const Answer answer = wait_for_one(client);
    // A status that became another one is the server's own no; nothing else may come through but the
    // fragments.
    if (answer.ok())
      EXPECT_EQ(answer.body, kFragments) << at.load();
    else
      EXPECT_EQ(answer.failure, Failure::kRefused) << at.load() << ": " << answer.detail;
  }
}

TEST(ProtocolClient, AnAnswerOverTheLimitIsRefusedUnread) {
  FakeServer server([](const FakeRequest&) {
    return FakeReply{"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\nabc"};
  });
  Settings s = settings(server.port());
  s.max_answer_bytes = 1000;
  Client client(s);
  client.fracture("sha256:0", {});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.failure, Failure::kTooLarge);
  EXPECT_NE(answer.detail.find("1000"), std::string::npos) << answer.detail;
}

TEST(ProtocolClient, ParametersOverTheLimitAreNotSent) {
  FakeServer server([](const FakeRequest&) { return fragments(); });
  Client client(settings(server.port()));
  const Ticket ticket = client.fracture("sha256:0", {{"nodes", std::string(5000, 'x')}});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.ticket, ticket);
  EXPECT_EQ(answer.failure, Failure::kTooLarge);
  EXPECT_TRUE(server.requests().empty());
}

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
  s.connections = 1;  // the second waits for the connection of the first
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

TEST(ProtocolClient, TheClientEndsWhileRequestsAreOpen) {
  FakeServer server([](const FakeRequest&) { return FakeReply{"", false, true}; });
  Settings s = settings(server.port());
  s.connections = 2;
  Client client(s);
  for (int k = 0; k < 10; ++k) client.fracture("sha256:0", {});
  test::require_eventually(test::kPatience, "two requests", [&] { return server.requests().size() >= 2; });
}

/// A port on which nobody listens: it was given to a server that is gone.
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
    reply.close = request.number == 0;  // without saying Connection: close
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
