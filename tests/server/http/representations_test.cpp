// The forms in which a result is sent (reports, codings, parts), and what is decided before any of them is
// made.
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <atomic>
#include <set>
#include <thread>
#include <vector>

#include "common/base/execution.hpp"
#include "common/digest/digest.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

std::string repr_digest(const std::string& body) {
  const Digest digest = sha256(body);
  std::string base64(64, '\0');
  base64.resize(static_cast<std::size_t>(
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(base64.data()), digest.bytes.data(), 32)));
  return "sha-256=:" + base64 + ":";
}

std::string decoded(const Reply& reply) {
  std::string body = reply.body;
  MemoryBudget budget(1u << 30);
  MemoryBudget::Reservation reservation(budget);
  const auto coding = http::content_coding(reply.header("content-encoding"));
  EXPECT_FALSE(http::decode_body(body, coding.value(), 1u << 30, reservation, {}).problem);
  return body;
}

struct Representations : testing::Test {
  TestServer server;
  Reply made;
  std::string location;
  Representations() {
    server.control->glb_padding = 100'000;
    made = server.post("/fracture?sites=9");
    location = made.header("content-location");
  }
  Reply get(const std::string& fields) { return server.get(location, fields); }
};

TEST_F(Representations, FiguresAreTheTextThatStandsInTheFile) {
  const Reply figures = get("Accept: application/json\r\n");
  ASSERT_EQ(figures.status, 200);
  EXPECT_NE(made.body.find(figures.body), std::string::npos) << "nothing was parsed and written again";
  EXPECT_EQ(figures.json().at("fragments"), 9);
  EXPECT_EQ(figures.json().at("parameters").at("sites"), 9);
  EXPECT_EQ(figures.header("repr-digest"), repr_digest(figures.body));
  EXPECT_NE(figures.header("etag"), made.header("etag"));
  EXPECT_EQ(get("Accept: application/json\r\nIf-None-Match: " + figures.header("etag") + "\r\n").status, 304);
  const Reply head = ask(server.port(), "HEAD", location, "Accept: application/json\r\n");
  EXPECT_EQ(head.header("content-length"), std::to_string(figures.body.size()));
  EXPECT_EQ(head.header("etag"), figures.header("etag"));
}

TEST_F(Representations, FiguresComeFromTheDiskToo) {
  const TemporaryFolder folder;
  TestServerOptions options;
  options.service.tiers.folder = folder.path + "/cache";
  Reply before;
  {
    TestServer first(options);
    before =
        first.post("/fracture?sites=9", "mesh", "Content-Type: model/obj\r\nAccept: application/json\r\n");
    first.service.tiers().flush();
  }
  TestServer second(options);
  const Reply after = second.get(before.header("content-location"), "Accept: application/json\r\n");
  EXPECT_EQ(after.body, before.body);
  EXPECT_EQ(after.header("repr-digest"), before.header("repr-digest"));
  EXPECT_EQ(after.header("cache-status"), "disk; hit, result; fwd=miss; stored");
}

TEST_F(Representations, EachCodingIsARepresentationOfItsOwn) {
  std::set<std::string> etags = {made.header("etag")};
  for (const std::string coding : {"gzip", "zstd"})
    for (const std::string accept : {"", "Accept: application/json\r\n"}) {
      const Reply plain = get(accept), reply = get(accept + "Accept-Encoding: " + coding + "\r\n");
      if (plain.body.size() < 1024) continue;  // too small to be compressed
      ASSERT_EQ(reply.status, 200) << coding;
      EXPECT_EQ(reply.header("content-encoding"), coding);
      EXPECT_LT(reply.body.size(), plain.body.size() / 2) << coding;
      EXPECT_EQ(decoded(reply), plain.body);
      EXPECT_EQ(reply.header("content-type"), plain.header("content-type"));
      EXPECT_EQ(reply.header("repr-digest"), repr_digest(reply.body)) << "RFC 9530: with its coding";
      EXPECT_NE(reply.header("vary").find("Accept-Encoding"), std::string::npos);
      EXPECT_NE(plain.header("vary").find("Accept-Encoding"), std::string::npos);
      EXPECT_TRUE(etags.insert(reply.header("etag")).second) << reply.header("etag");
      EXPECT_EQ(
          get(accept + "Accept-Encoding: " + coding + "\r\nIf-None-Match: " + reply.header("etag") + "\r\n")
              .status,
          304);
      EXPECT_EQ(get(accept + "Accept-Encoding: " + coding + "\r\n").body, reply.body);
    }
  EXPECT_EQ(etags.size(), 3u);
}

TEST_F(Representations, APostIsAnsweredCompressedWhereThatIsAskedFor) {
  for (const char* query : {"/fracture?sites=9", "/fracture?sites=10"}) {  // cached, then computed
    const Reply reply =
        server.post(query, "a mesh", "Content-Type: model/gltf-binary\r\nAccept-Encoding: zstd\r\n");
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.header("content-encoding"), "zstd");
    EXPECT_EQ(decoded(reply).substr(0, 4), "glTF");
    EXPECT_NE(reply.header("server-timing"), "");
  }
}

TEST_F(Representations, QualitiesDecide) {
  const auto chosen = [&](const std::string& field) {
    const Reply reply = get("Accept-Encoding: " + field + "\r\n");
    return reply.status == 200 ? reply.header("content-encoding") : std::to_string(reply.status);
  };
  EXPECT_EQ(chosen("gzip, zstd"), "zstd");
  EXPECT_EQ(chosen("gzip, deflate, br"), "gzip");
  EXPECT_EQ(chosen("zstd;q=0.5, gzip;q=0.8"), "gzip");
  EXPECT_EQ(chosen("ZSTD;Q=1"), "zstd");
  EXPECT_EQ(chosen("x-gzip"), "gzip");
  EXPECT_EQ(chosen("gzip;q=0, *"), "zstd");
  EXPECT_EQ(chosen("br"), "");
  EXPECT_EQ(chosen("*;q=0"), "406");
  EXPECT_EQ(chosen("identity;q=0, br"), "406");
  EXPECT_EQ(chosen("identity;q=0, gzip"), "gzip");
  EXPECT_EQ(chosen("identity, gzip;q=0.5"), "");
  EXPECT_EQ(chosen("identity;q=0.5, gzip;q=0.1"), "");
  EXPECT_EQ(chosen("gzip;q=0.001"), "gzip") << "what is named goes before what is not";
  EXPECT_EQ(chosen("gzip;q=2"), "") << "malformed items are skipped";
}

TEST_F(Representations, APartIsOneOfThePlainBytes) {
  const Reply part = get("Accept-Encoding: gzip, zstd\r\nRange: bytes=0-3\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, "glTF");
  EXPECT_EQ(part.header("content-encoding"), "");
  EXPECT_EQ(part.header("etag"), made.header("etag"));
  const Reply whole = get("Accept-Encoding: gzip\r\n");
  EXPECT_EQ(
      get("Accept-Encoding: gzip\r\nRange: bytes=0-3\r\nIf-Range: " + whole.header("etag") + "\r\n").status,
      200)
      << "a part of the compressed bytes cannot be had";
}

TEST_F(Representations, AHeadOrACheckOfWhatNobodyCompressedMakesNothing) {
  const std::string gzip = "Accept-Encoding: gzip\r\n";
  const std::size_t entries = server.service.figures().results.entries;
  const Reply head = ask(server.port(), "HEAD", location, gzip);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.header("content-encoding"), "gzip");
  EXPECT_EQ(head.header("content-length"), "");
  EXPECT_EQ(get(gzip + "If-None-Match: " + head.header("etag") + "\r\n").status, 304);
  EXPECT_EQ(server.service.figures().results.entries, entries);
  const Reply whole = get(gzip);
  EXPECT_EQ(whole.header("etag"), head.header("etag"));
  EXPECT_EQ(server.service.figures().results.entries, entries + 1) << "kept beside the result";
  EXPECT_EQ(ask(server.port(), "HEAD", location, gzip).header("content-length"),
            std::to_string(whole.body.size()));
}

TEST_F(Representations, ManyWhoWantTheSameCodingGetTheSameBytes) {
  std::vector<std::string> bodies(8);
  std::vector<std::thread> clients;
  for (std::string& body : bodies)
    clients.emplace_back([&] { body = get("Accept-Encoding: zstd\r\n").body; });
  for (std::thread& client : clients) client.join();
  for (const std::string& body : bodies) EXPECT_EQ(body, bodies.front());
  EXPECT_EQ(server.service.figures().results.entries, 2u);
}

TEST_F(Representations, WhatIsKeptBesideAResultIsNoResult) {
  get("Accept-Encoding: zstd\r\n");
  EXPECT_EQ(server.get(location + ".zstd").status, 404);
  EXPECT_EQ(server.post("/fracture?of=" + location + ".zstd").status, 400);
}

TEST(Figures, AreFoundWithoutParsingWhateverTheTextIs) {
  const auto find = [](const std::string& text) {
    const std::vector<std::uint8_t> file(text.begin(), text.end());
    const auto range = figures_in(file, OutputFormat::kGltf);
    return range ? text.substr(range->at, range->size) : "nothing";
  };
  const std::string root = R"({"bonds":{"a":[1,2]},"x":"}\"]"})";
  EXPECT_EQ(find(R"({"nodes":[{"extras":{"fracture":)" + root + "}}]}"), root);
  EXPECT_EQ(
      find(
          R"( { "asset" : {"nodes":[1]}, "n":-1.5e3 , "t":true, "nodes" : [ {"extras":{"fracture":{"id":1}}} , {"extras" : { "fracture" : )" +
          root + " } } ] }"),
      root);
  for (const char* text :
       {"", "{", "[]", "nodes", "{\"nodes\":[", "{\"nodes\":[]}", "{\"nodes\":[{}]}", "{\"nodes\":{}}",
        "{\"nodes\":[{\"extras\":", "{\"a\\", "{\"a\":\"\\", "{\"nodes\":[}}}}]}", "{\"nodes\":,}",
        "{\"nodes\":[{\"extras\":{\"fracture\":{\"bonds\":"})
    EXPECT_EQ(find(text), "nothing") << text;
  EXPECT_EQ(find("{\"a\":" + std::string(1'000'000, '[')), "nothing") << "depth costs no stack";
}

TEST(Figures, AGlbWhoseLengthsLieHasNone) {
  for (std::size_t size = 0; size < 24; ++size)
    EXPECT_FALSE(figures_in(std::vector<std::uint8_t>(size, 0xff), OutputFormat::kGlb)) << size;
}

// The answer exists. If it cannot be compressed now, it is sent uncompressed.
TEST(RepresentationsOfABusyServer, AnAnswerIsSentAsItIsWhereNoThreadCanCompressIt) {
  TestServerOptions options;
  options.threads = 1;
  options.max_queue = 0;
  TestServer server(options);
  server.control->glb_padding = 100'000;
  const std::string location = server.post("/fracture?sites=9").header("content-location");
  std::atomic<bool> began{false}, go_on{false};
  server.control->during_cut = [&](const Execution&) {
    began = true;
    eventually(kPatience, "the answers beside it", [&] { return go_on.load(); });
  };
  ASSERT_TRUE(eventually(kPatience, "an idle thread", [&] { return server.pool.running() == 0; }));
  std::thread busy([&] { EXPECT_EQ(server.post("/fracture?sites=10").status, 200); });
  EXPECT_TRUE(eventually(kPatience, "a busy thread", [&] { return began.load(); }));
  const Reply plain = server.get(location, "Accept-Encoding: gzip\r\n");
  EXPECT_EQ(plain.status, 200) << plain.body;
  EXPECT_EQ(plain.header("content-encoding"), "");
  EXPECT_EQ(plain.header("repr-digest"), repr_digest(plain.body));
  EXPECT_EQ(plain.header("etag").find("gzip"), std::string::npos) << plain.header("etag");
  EXPECT_EQ(server.get(location, "Accept-Encoding: gzip, identity;q=0\r\n").status, 503);
  go_on = true;
  busy.join();
  EXPECT_TRUE(eventually(kPatience, "an idle thread", [&] { return server.pool.running() == 0; }));
  EXPECT_EQ(server.get(location, "Accept-Encoding: gzip\r\n").header("content-encoding"), "gzip");
}

/// Deadlines that no test reaches.
TestServerOptions patient() {
  TestServerOptions options;
  options.limits.deadline = options.limits.realtime_deadline = kPatience;
  return options;
}

// A realtime request does not wait for a compression that is queued in a less urgent class.
TEST(RepresentationsOfABusyServer, ACollisionCompressesForAllWhatABatchRequestWaitsFor) {
  Gate gate;
  TestServer server(patient());
  server.control->glb_padding = 100'000;
  const std::string location = server.post("/fracture?sites=9").header("content-location");
  server.control->during_cut = gate.hook_without_polls();
  std::vector<std::thread> busy;
  for (int k = 0; k < 2; ++k)
    busy.emplace_back(
        [&, k] { EXPECT_EQ(server.post("/fracture?sites=" + std::to_string(10 + k)).status, 200); });
  EXPECT_TRUE(eventually(kPatience, "two busy threads", [&] { return gate.arrived == 2; }));
  const std::string get = "GET " + location + " HTTP/1.1\r\nHost: t\r\nAccept-Encoding: gzip\r\n";
  RawClient batch(server.port()), realtime(server.port());
  batch.send(get + "Priority: u=5\r\n\r\n");
  EXPECT_TRUE(eventually(kPatience, "the batch request to wait", [&] { return server.pool.queued() == 1; }));
  realtime.send(get + "Priority: u=1\r\n\r\n");
  const auto urgent = realtime.receive();
  EXPECT_TRUE(urgent && urgent->status == 200 && urgent->header("content-encoding") == "gzip");
  const auto later = batch.receive();
  EXPECT_FALSE(gate.open) << "it is also the answer to the batch request";
  gate.open = true;
  for (std::thread& thread : busy) thread.join();
  ASSERT_TRUE(later && urgent);
  EXPECT_EQ(later->header("etag"), urgent->header("etag"));
  EXPECT_EQ(later->body, urgent->body);
}

// The job's low priority ends with its computation, because a client waits for its answer.
TEST(RepresentationsOfABusyServer, TheAnswerOfAJobIsCompressedBeforeFurtherJobs) {
  Gate first, others;
  std::atomic<int> cuts{0};
  TestServerOptions options = patient();
  options.threads = 1;
  TestServer server(options);
  server.control->glb_padding = 100'000;
  server.control->during_cut = [&](const Execution& execution) {
    (cuts++ == 0 ? first : others).pass(execution);
  };
  const auto job = [&](int sites, const std::string& more) {
    return "POST /fracture?sites=" + std::to_string(sites) +
           " HTTP/1.1\r\nHost: t\r\nContent-Type: model/gltf-binary\r\nAccept-Encoding: gzip\r\n"
           "Prefer: respond-async" +
           more + "\r\nContent-Length: 4\r\n\r\nmesh";
  };
  RawClient waits(server.port()), starts(server.port());
  waits.send(job(9, ", wait=60"));
  EXPECT_TRUE(eventually(kPatience, "the job to be computed", [&] { return first.arrived == 1; }));
  starts.send(job(10, ""));
  const auto accepted = starts.receive();
  EXPECT_TRUE(accepted && accepted->status == 202);
  EXPECT_TRUE(eventually(kPatience, "the other job to wait", [&] { return server.pool.queued() == 1; }));
  first.open = true;
  const auto answer = waits.receive();
  EXPECT_EQ(server.dispatcher.figures().computed, 1u) << "the other job is not done";
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200) << answer->body.substr(0, 300);
  EXPECT_EQ(answer->header("content-encoding"), "gzip");
  others.open = true;
  server.dispatcher.wait_idle();
}

}  // namespace
}  // namespace fracture::test
