// Answers are either read unchanged or refused: fields, digests, limits.
#include "common/exchange/headers.hpp"
#include "tests/client/protocol_fixture.hpp"

namespace fracture::protocol {
namespace {

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
  // The digest of empty data is known from FIPS 180-4's examples; its base64 comes from coreutils.
  const std::string of_nothing = "sha-256=:47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=:";
  EXPECT_TRUE(digest_matches(of_nothing, ""));
  EXPECT_TRUE(digest_matches("md5=:x:, " + of_nothing, ""));
  EXPECT_FALSE(digest_matches(of_nothing, "x"));
  EXPECT_FALSE(digest_matches("md5=:x:", ""));
  EXPECT_EQ(mesh_id(""), "sha256:e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
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
      reply.close = true;  // so that the client does not wait for a longer body
    }
    return reply;
  });
  Client client(settings(server.port()));
  for (at = 0; at < whole.size(); ++at) {
    flip = true;
    client.fracture("sha256:0", {});
    const Answer answer = wait_for_one(client);
    // If the flipped bit changed the status, the client reports a refusal by the server. Otherwise only the
    // intact fragments may arrive.
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
  const Ticket ticket = client.fracture("sha256:0", {{"nodes", std::string(70'000, 'x')}});
  const Answer answer = wait_for_one(client);
  EXPECT_EQ(answer.ticket, ticket);
  EXPECT_EQ(answer.failure, Failure::kTooLarge);
  EXPECT_TRUE(server.requests().empty());
}

}  // namespace
}  // namespace fracture::protocol
