// Results as resources: GET and HEAD /fractures/{id}.
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include "common/base/digest.hpp"
#include "tests/server/test_server.hpp"

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

TEST_F(Results, TheFiguresOfAGlbCanBeHadToo) {
  const Reply figures = server.get(location, "Accept: application/json\r\n");
  EXPECT_EQ(figures.status, 200);
  EXPECT_TRUE(figures.json().contains("bonds"));
  EXPECT_NE(figures.header("etag"), etag);
  EXPECT_EQ(server.get(location, "Accept: model/gltf+json\r\n").problem(), "not-acceptable");
}

}  // namespace
}  // namespace fracture::test
