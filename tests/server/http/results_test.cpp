// Results as resources: GET and HEAD /fractures/{id}.
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <future>

#include "common/digest/digest.hpp"
#include "server/http/limits.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/server/support/test_server.hpp"

namespace fracture::test {
namespace {

struct Results : testing::Test {
  TestServer server;
  Reply made = server.post("/fracture");
  std::string location = made.header("content-location"), etag = made.header("etag");
  std::string size = std::to_string(made.body.size());
};

TEST_F(Results, TheyAreImmutableAndSayWhatTheyAre) {
  const Reply got = server.get(location);
  ASSERT_EQ(got.status, 200);
  EXPECT_EQ(got.body, made.body);
  EXPECT_EQ(got.header("etag"), etag);
  EXPECT_NE(got.header("cache-control").find("immutable"), std::string::npos);
  EXPECT_EQ(got.header("accept-ranges"), "bytes");
  EXPECT_EQ(got.header("cache-status"), "result; hit");
}

TEST_F(Results, TheDigestIsThatOfTheBytes) {
  const Digest digest = sha256(made.body);
  std::string base64(64, '\0');
  base64.resize(static_cast<std::size_t>(
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(base64.data()), digest.bytes.data(), 32)));
  EXPECT_EQ(made.header("repr-digest"), "sha-256=:" + base64 + ":");
  EXPECT_EQ(server.get(location, "Range: bytes=0-3\r\n").header("repr-digest"), made.header("repr-digest"));
}

TEST_F(Results, OneRangeIsAnsweredWithThatPart) {
  const auto range = [&](const std::string& text) { return server.get(location, "Range: " + text + "\r\n"); };
  const Reply first = range("bytes=0-3");
  EXPECT_EQ(first.status, 206);
  EXPECT_EQ(first.body, "glTF");
  EXPECT_EQ(first.header("content-range"), "bytes 0-3/" + size);
  EXPECT_EQ(first.header("etag"), etag);
  EXPECT_EQ(range("bytes=4-").body, made.body.substr(4));
  EXPECT_EQ(range("bytes=-5").body, made.body.substr(made.body.size() - 5));
  EXPECT_EQ(range("bytes=-999999999").body, made.body);
  EXPECT_EQ(range("bytes=10-99999999999999").body, made.body.substr(10));
}

TEST_F(Results, ARangeOutsideIsRefusedWithTheSize) {
  for (const std::string& range :
       {"bytes=" + size + "-", std::string("bytes=99999999-"), std::string("bytes=-0")}) {
    const Reply reply = server.get(location, "Range: " + range + "\r\n");
    EXPECT_EQ(reply.status, 416) << range;
    EXPECT_EQ(reply.problem(), "range-not-satisfiable") << range;
    EXPECT_EQ(reply.header("content-range"), "bytes */" + size) << range;
  }
}

TEST_F(Results, WhatIsNoSingleRangeOfBytesIsAnsweredWithTheWhole) {
  for (const char* range : {"bytes=0-1,4-5", "lines=1-2", "bytes=5-2", "bytes=x-2", "bytes=-", "bytes=1",
                            "bytes", "bytes=18446744073709551616-"}) {
    const Reply reply = server.get(location, std::string("Range: ") + range + "\r\n");
    EXPECT_EQ(reply.status, 200) << range;
    EXPECT_EQ(reply.body, made.body) << range;
  }
  EXPECT_EQ(ask(server.port(), "HEAD", location, "Range: bytes=0-3\r\n").status, 200);
}

TEST_F(Results, IfRangeHoldsTheRangeToTheSameBytes) {
  EXPECT_EQ(server.get(location, "Range: bytes=0-3\r\nIf-Range: " + etag + "\r\n").status, 206);
  EXPECT_EQ(server.get(location, "Range: bytes=0-3\r\nIf-Range: \"other\"\r\n").status, 200);
  EXPECT_EQ(server.get(location, "Range: bytes=0-3\r\nIf-None-Match: " + etag + "\r\n").status, 304);
}

TEST_F(Results, IfMatchHoldsTheAnswerToTheSameBytes) {
  for (const std::string& good : {etag, std::string("*"), "\"other\", " + etag})
    EXPECT_EQ(server.get(location, "If-Match: " + good + "\r\n").status, 200) << good;
  for (const std::string& bad : {std::string("\"other\""), "W/" + etag}) {
    for (const char* method : {"GET", "HEAD"})
      EXPECT_EQ(ask(server.port(), method, location, "If-Match: " + bad + "\r\n").status, 412)
          << method << bad;
    const Reply reply = server.get(location, "If-Match: " + bad + "\r\nIf-None-Match: " + etag + "\r\n");
    EXPECT_EQ(reply.problem(), "precondition-failed") << "before If-None-Match";
    EXPECT_NE(reply.body.find(etag.substr(1, 20)), std::string::npos) << reply.body;
  }
  EXPECT_EQ(server.get(location, "Accept: application/json\r\nIf-Match: " + etag + "\r\n").status, 412)
      << "the figures have an ETag of their own";
}

TEST_F(Results, TheFiguresOfAGlbCanBeHadToo) {
  const Reply figures = server.get(location, "Accept: application/json\r\n");
  EXPECT_EQ(figures.status, 200);
  EXPECT_TRUE(figures.json().contains("bonds"));
  EXPECT_NE(figures.header("etag"), etag);
  EXPECT_EQ(server.get(location, "Accept: model/gltf+json\r\n").problem(), "not-acceptable");
}

TEST_F(Results, FurtherRequestsMayNameThem) {
  const auto parameters_of = [](const Reply& reply) { return reply.json().at("parameters"); };
  const std::string json = "Content-Type: model/gltf-binary\r\nAccept: application/json\r\n";
  const Reply first = server.post("/fracture?sites=7&seed=3");
  const std::string of = first.header("content-location");
  const Reply again = server.post("/fracture?of=" + of + "&density=5", "a mesh", json);
  ASSERT_EQ(again.status, 200) << again.body;
  EXPECT_EQ(parameters_of(again).at("sites"), 7);
  EXPECT_EQ(parameters_of(again).at("seed"), 3);
  EXPECT_EQ(parameters_of(again).at("density"), 5);
  EXPECT_FALSE(parameters_of(again).contains("of"));
  // The same in JSON, for a stored mesh, with the full address.
  const std::string id = server.post("/meshes").json().at("id");
  const Reply stored = server.post_json("/meshes/" + id + "/fracture",
                                        nlohmann::json{{"of", "http://host:1" + of}, {"density", 5}}.dump(),
                                        "Accept: application/json\r\n");
  ASSERT_EQ(stored.status, 200) << stored.body;
  EXPECT_EQ(parameters_of(stored), parameters_of(again));
}

TEST_F(Results, AnAnswerThatIsNotKnownOrOfAnotherMeshCannotBeNamed) {
  const Reply unknown = server.post("/fracture?of=sha256:" + std::string(64, '0'));
  EXPECT_EQ(unknown.status, 404);
  EXPECT_EQ(unknown.problem(), "no-such-answer");
  EXPECT_EQ(unknown.json().at("parameter"), "of");
  const Reply other = server.post("/fracture?of=" + location, "another mesh");
  EXPECT_EQ(other.status, 400);
  EXPECT_EQ(other.problem(), "bad-parameter");
  EXPECT_EQ(other.json().at("parameter"), "of");
  const Reply nonsense = server.post("/fracture?of=yesterday");
  EXPECT_EQ(nonsense.status, 400);
  EXPECT_EQ(nonsense.problem(), "bad-parameter");
}

TEST(FurtherRequests, WhoseEarlierParametersAreManyAreReadOnThePool) {
  TestServerOptions options;
  options.threads = 1;
  TestServer server(options);
  nlohmann::json points = nlohmann::json::array();
  while (points.dump().size() <= http::kEarlierInline)
    for (int k = 0; k < 1000; ++k)
      points.push_back({0.001 * k, 0.5, 1e-6 * static_cast<double>(points.size())});
  const std::string boundary = "x--x";
  const std::string form =
      "--" + boundary + "\r\nContent-Disposition: form-data; name=mesh; filename=a.glb\r\n\r\n" +
      "a mesh\r\n--" + boundary + "\r\nContent-Disposition: form-data; name=params\r\n\r\n" +
      nlohmann::json{{"pattern", "points"}, {"points", points}}.dump() + "\r\n--" + boundary + "--\r\n";
  const std::string many =
      server.post("/fracture", form, "Content-Type: multipart/form-data; boundary=" + boundary + "\r\n")
          .header("content-location");
  const std::string few = server.post("/fracture?sites=7").header("content-location");
  ASSERT_FALSE(many.empty() || few.empty());
  const std::string id = server.post("/meshes").json().at("id");
  const auto ask = [&](const std::string& of) {
    return server.post_json("/meshes/" + id + "/fracture", nlohmann::json{{"of", of}, {"unit", "cm"}}.dump())
        .status;
  };
  Gate gate;
  server.pool.submit(Priority::kRealtime, 0, [&](int) { gate.pass_without_polls(); });
  gate.wait_for(1);
  EXPECT_EQ(ask(few), 400) << "at once, though no thread of the pool is free";
  auto answer = std::async(std::launch::async, [&] { return ask(many); });
  EXPECT_TRUE(eventually(kPatience, "it to wait for the pool", [&] { return server.pool.queued() == 1; }));
  gate.open = true;
  EXPECT_EQ(answer.get(), 400);
}

}  // namespace
}  // namespace fracture::test
