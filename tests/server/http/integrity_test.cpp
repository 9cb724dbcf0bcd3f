// Content-Digest of requests, and the pages that describe the types of problems.
#include <gtest/gtest.h>

#include <random>

#include "common/digest/digest.hpp"
#include "server/http/content_digest.hpp"
#include "tests/server/support/gzip.hpp"
#include "tests/server/support/test_server.hpp"

namespace fracture::test {
namespace {

// RFC 9530, appendices B.1 and D: the digests of {"hello": "world"} and a line feed.
const std::string kHello = "{\"hello\": \"world\"}\n";
const std::string kSha256 = "sha-256=:RK/0qy18MlBSVnWgjwz6lZEWjP/lF5HF9bvEF8FabDg=:";
const std::string kSha512 =
    "sha-512=:YMAam51Jz/jOATT6/zvHrLVgOYTGFy1d6GJiOHTohq4yP+pgk4vf2aCsyRZOtw8MjkM7iw7yZ/WkppmM44T3qg==:";

TEST(ContentDigest, OfTheStandardsExamplesHolds) {
  for (const std::string& field : {kSha256, kSha512, kSha256 + ", " + kSha512, "unixsum=:AAAA:, " + kSha256,
                                   "md5=:AAAA:" + std::string(), kSha256 + ";x=1"})
    EXPECT_FALSE(http::check_content_digest(field, kHello)) << field;
}

TEST(ContentDigest, AnotherBodyIsRefusedByEachOfThem) {
  for (const std::string& field : {kSha256, kSha512, "md5=:AAAA:, " + kSha512}) {
    const auto problem = http::check_content_digest(field, kHello + " ");
    ASSERT_TRUE(problem) << field;
    EXPECT_EQ(problem->type->slug, "content-digest-mismatch");
  }
}

// A field of 16 KiB has room for 280 digests.
TEST(ContentDigest, ABodyIsReadOnceForAnAlgorithmAndWithPolls) {
  const std::string body(4 << 20, 'x');
  const auto polls_of = [&](const std::string& field) {
    int polls = 0;
    Execution execution;
    execution.watch = [&polls] { ++polls; };
    EXPECT_EQ(http::check_content_digest(field, body, execution)->type->slug, "content-digest-mismatch")
        << field;
    return polls;
  };
  const int once = polls_of(kSha256);
  EXPECT_GE(once, 4) << "a megabyte at once at most";
  std::string many = kSha256;
  for (int k = 0; k < 200; ++k) many += ", " + kSha256;
  EXPECT_EQ(polls_of(many), once);
  EXPECT_FALSE(http::check_content_digest("sha-256=:AAAA:, " + kSha256, kHello)) << "the last one counts";
}

TEST(ContentDigest, WhatIsNoDictionaryOfByteSequencesIsMalformed) {
  for (const std::string field :
       {"sha-256", "sha-256=abc", "sha-256=:", "=:AAAA:", "sha-256=:AAAA", ":AAAA:"}) {
    const auto problem = http::check_content_digest(field, kHello);
    ASSERT_TRUE(problem) << field;
    EXPECT_EQ(problem->type->slug, "malformed-request") << field;
  }
}

TEST(ContentDigest, IsCheckedBeforeTheBodyIsUsed) {
  TestServer server;
  const std::string obj = "Content-Type: model/obj\r\n";
  EXPECT_EQ(server.post("/fracture", kHello, obj + "Content-Digest: " + kSha256 + "\r\n").status, 200);
  EXPECT_EQ(server.control->imports, 1);
  for (const std::string& body :
       {std::string("damaged"), std::string(1u << 20, 'x')}) {  // small: on the io thread; large: in the pool
    const Reply refused = server.post("/fracture", body, obj + "Content-Digest: " + kSha256 + "\r\n");
    EXPECT_EQ(refused.status, 400);
    EXPECT_EQ(refused.problem(), "content-digest-mismatch");
  }
  EXPECT_EQ(server.control->imports, 1);
}

TEST(ContentDigest, OfALargeCompressedBodyIsCheckedInTheStepThatDecodesIt) {
  TestServer server;
  std::string mesh(1u << 20, '\0');
  std::mt19937 random(1);
  for (char& c : mesh) c = static_cast<char>(random());
  const std::string body = gzip(mesh);
  ASSERT_GT(body.size(), http::kReadInline) << "too much for an io thread";
  const std::string fields = "Content-Type: model/obj\r\nContent-Encoding: gzip\r\nContent-Digest: ";
  const auto tasks = [&] { return server.pool.submit(Priority::kBatch, 0, [](int) {}); };
  WorkerPool::TaskId before = tasks();
  const Reply made =
      server.post("/fracture", body, fields + "sha-256=:" + base64(sha256(body).bytes) + ":\r\n");
  ASSERT_EQ(made.status, 200) << made.body;
  EXPECT_EQ(tasks() - before - 1, 2u) << "the body, and the computation";
  EXPECT_EQ(server.control->imports, 1);
  before = tasks();
  EXPECT_EQ(server.post("/fracture?seed=2", body, fields + kSha256 + "\r\n").problem(),
            "content-digest-mismatch");
  EXPECT_EQ(tasks() - before - 1, 1u);
  EXPECT_EQ(server.api.bodies().whole().used(), 0u);
}

TEST(Problems, EveryTypeLeadsToAPageForPeople) {
  TestServer server;
  for (const http::ProblemType& type : http::problem_types()) {
    const std::string address = "/problems/" + std::string(type.slug);
    const Reply text = server.get(address), html = server.get(address, "Accept: text/html,*/*;q=0.8\r\n");
    EXPECT_EQ(text.status, 200) << address;
    EXPECT_EQ(text.header("content-type"), "text/plain; charset=utf-8");
    EXPECT_NE(text.body.find(type.title), std::string::npos) << address;
    EXPECT_NE(text.body.find(std::to_string(type.status)), std::string::npos) << address;
    EXPECT_GE(type.advice.size(), 15u) << address;
    EXPECT_NE(text.body.find(type.advice), std::string::npos) << address;
    EXPECT_EQ(html.header("content-type"), "text/html; charset=utf-8");
    EXPECT_NE(html.body.find("<h1>"), std::string::npos);
    EXPECT_EQ(html.body.find("<token>"), std::string::npos) << "text is escaped";
  }
  EXPECT_EQ(server.get("/problems/none").status, 404);
  EXPECT_EQ(server.get(server.get("/nothing").json().at("type")).status, 200);
}

TEST(Cors, APageMaySendWhatTheInterfaceKnows) {
  TestServerOptions options;
  options.server.cors_origins = {"https://example.org"};
  TestServer server(options);
  const std::string fields = ask(server.port(), "OPTIONS", "/fracture",
                                 "Origin: https://example.org\r\nAccess-Control-Request-Method: POST\r\n")
                                 .header("access-control-allow-headers");
  for (const char* name :
       {"Priority", "If-Match", "If-None-Match", "If-Range", "Range", "Content-Digest", "Prefer"})
    EXPECT_NE(fields.find(name), std::string::npos) << name;
}

}  // namespace
}  // namespace fracture::test
