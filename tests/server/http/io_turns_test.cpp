// An io thread does little for one client because all others wait for it: it hashes, inflates, parses and
// sorts no more than limits.hpp allows. Every TestServer counts turns that do more, and fails if there are
// any. These tests show which work goes to the pool instead, and which is done only once.
#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <optional>
#include <utility>

#include "common/digest/digest.hpp"
#include "server/page/page.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/server/support/gzip.hpp"
#include "tests/server/support/job_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

const std::string kOfGlb = "Content-Type: model/gltf-binary\r\n",
                  kJson = "Content-Type: application/json\r\n";

/// Answers a request on this thread, as a session passes it to the Api.
http::Response respond(TestServer& server, const std::string& method, const std::string& target,
                       const std::string& fields = "") {
  const auto request = std::make_shared<http::Request>();
  request->head = *http::parse_head(method + " " + target + " HTTP/1.1\r\nHost: a\r\n" + fields + "\r\n", {});
  request->admission = *server.api.admit(http::Listener::kPublic, request->head);
  std::optional<http::Response> answer;
  server.api.start(request, {}, [&](http::Response response) { answer = std::move(response); });
  return answer.value();
}

TEST(IoTurns, AFileOfThePageIsSentFromWhereItLies) {
  TestServer server;
  if (page::files().empty()) GTEST_SKIP() << "this server was built without its page";
  for (const page::File& file : page::files()) {
    if (file.path.ends_with(".html")) continue;
    for (const char* method : {"GET", "HEAD"}) {
      const http::Response plain = respond(server, method, "/page/" + std::string(file.path)),
                           packed = respond(server, method, "/page/" + std::string(file.path),
                                            "Accept-Encoding: gzip\r\n");
      EXPECT_EQ(plain.body.data(), file.plain.data()) << file.path;
      EXPECT_EQ(packed.body.data(), file.gzip.data()) << file.path;
      EXPECT_FALSE(plain.owner || packed.owner) << "nothing was made for it";
    }
  }
}

TEST(IoTurns, WhatIsLongAndNeverChangesIsWrittenOnce) {
  TestServer server;
  const std::string mesh = server.post("/meshes", "a mesh").header("location");
  for (const std::string& target : {std::string("/limits"), std::string("/patterns"),
                                    std::string("/openapi.json"), std::string("/llms.txt"), mesh}) {
    const http::Response one = respond(server, "GET", target), other = respond(server, "GET", target);
    EXPECT_GT(one.body.size(), 0u);
    EXPECT_EQ(one.body.data(), other.body.data()) << target;
  }
  EXPECT_EQ(server.get(mesh).body, server.post("/meshes", "a mesh").body);
}

/// A server whose only thread does nothing until the gate opens.
struct Blocked : testing::Test {
  static TestServerOptions one_thread() {
    TestServerOptions options;
    options.threads = 1;
    return options;
  }
  TestServer server{one_thread()};
  Gate gate;
  std::string mesh, large;  // a stored mesh; an answer to it that has many parameters

  void SetUp() override {
    mesh = server.post("/meshes", "a mesh").header("location");
    nlohmann::json points = nlohmann::json::array();
    for (int k = 0; k < 200; ++k) points.push_back({0.001 * k, 0.5, 0.25});
    large =
        server
            .post("/fracture", form(nlohmann::json{{"pattern", "points"}, {"points", points}}.dump()), kForm)
            .header("content-location");
    ASSERT_NE(large, "");
    server.post_json(mesh + "/fracture", "{\"sites\": 7}");
    server.pool.wait_idle();
    server.pool.submit(Priority::kRealtime, 0, [this](int) { gate.pass_without_polls(); });
    gate.wait_for(1);
  }
  void TearDown() override { gate.open = true; }

  static std::string form(const std::string& params) {
    return "--B\r\nContent-Disposition: form-data; name=mesh; filename=a.glb\r\n\r\na mesh\r\n"
           "--B\r\nContent-Disposition: form-data; name=params\r\n\r\n" +
           params + "\r\n--B--\r\n";
  }
  static inline const std::string kForm = "Content-Type: multipart/form-data; boundary=B\r\n";
};

TEST_F(Blocked, WhatIsMoreThanAMomentsWorkWaitsForThePool) {
  const std::string k2 = "\"" + std::string(http::kParseInline, 'x') + "\"";
  const std::string digest =
      "Content-Digest: sha-256=:" + base64(sha256(std::string_view("other")).bytes) + ":\r\n";
  std::string entries, unknown, points;
  for (int k = 0; k < 40; ++k) {
    entries += (k > 0 ? ";a" : "a") + std::to_string(k) + ":ice";
    unknown += (k > 0 ? "&x" : "x") + std::to_string(k) + "=1";
    points += k > 0 ? ",[5,5,5]" : "[5,5,5]";
  }
  ASSERT_LT(std::max(entries.size(), unknown.size()), http::kParseInline - 100) << "few bytes";
  const struct {
    const char *name, *method;
    std::string target, fields, body;
  } cases[] = {
      {"a body", "POST", "/fracture", kOfGlb, std::string(http::kReadInline + 1, 'x')},
      {"a body whose digest is to be checked", "POST", "/fracture", kOfGlb + digest,
       std::string(http::kDigestInline + 1, 'x')},
      {"a compressed body", "POST", "/fracture", kOfGlb + "Content-Encoding: gzip\r\n", gzip("a mesh")},
      {"a form", "POST", "/fracture", kForm, form("{}")},
      {"a long query", "POST", "/fracture?" + std::string(http::kParseInline, 'x') + "=1", kOfGlb, "a mesh"},
      {"an answer named in the query", "POST", "/fracture?of=" + large, kOfGlb, "a mesh"},
      {"an answer named in JSON", "POST", mesh + "/fracture", kJson, "{\"of\": \"" + large + "\"}"},
      {"an answer named with a mesh", "POST", "/fracture", kJson,
       "{\"of\": \"" + large + "\", \"mesh\": \"" + mesh.substr(mesh.rfind('/') + 1) + "\"}"},
      {"long JSON", "POST", mesh + "/fracture", kJson, "{\"unit\": " + k2 + "}"},
      {"a long query with JSON", "POST", mesh + "/fracture?" + std::string(http::kParseInline, 'x') + "=1",
       kJson, "{}"},
      {"many entries of assign", "POST", mesh + "/estimate?assign=" + entries, "", ""},
      {"many entries of assign with a mesh", "POST", "/fracture?sites=0&assign=" + entries, kOfGlb, "a mesh"},
      {"many entries of assign in JSON", "POST", mesh + "/estimate", kJson,
       "{\"assign\": \"" + entries + "\"}"},
      {"many unknown names", "POST", mesh + "/fracture?" + unknown, "", ""},
      {"an estimate of many hits", "POST", mesh + "/estimate", kJson,
       "{\"local_point\": [" + points + "], \"local_radius\": 9}"},
      {"a mesh to be stored", "POST", "/meshes", kOfGlb, "a mesh"},
      {"a long list of jobs", "GET", "/jobs?limit=21", "", ""},
  };
  std::vector<std::future<int>> answers;
  for (const auto& c : cases) {
    answers.push_back(std::async(
        std::launch::async, [&] { return ask(server.port(), c.method, c.target, c.fields, c.body).status; }));
    EXPECT_TRUE(eventually(kPatience, std::string(c.name) + " to wait for the pool",
                           [&] { return server.pool.queued() == answers.size(); }));
  }
  // Meanwhile the io thread answers small requests whose results exist.
  EXPECT_EQ(server.post_json(mesh + "/fracture", "{\"sites\": 7}").status, 200);
  EXPECT_EQ(server.post("/fracture?sites=7", "a mesh").status, 200);
  EXPECT_EQ(server.get("/jobs").status, 200);
  EXPECT_EQ(server.get(mesh).status, 200);
  EXPECT_EQ(server.post("/fracture?sites=0").status, 400);
  EXPECT_EQ(server.post("/fracture?site=7").status, 400);
  EXPECT_EQ(server.post_json(mesh + "/estimate", "{\"sites\": 70}").status, 200);
  EXPECT_EQ(server.post_json(mesh + "/estimate?assign=a:ice;b:stone", "{}").status, 200);
  gate.open = true;
  for (auto& answer : answers) EXPECT_NE(answer.get(), 0);
}

// Formerly, the whole queue was sorted once for each job in the list.
TEST(IoTurns, AListOfJobsLooksAtTheQueueOnce) {
  TestServerOptions options;
  options.threads = 1;
  options.max_queue = 1000;
  TestServer server(options);
  Gate gate;
  server.control->during_cut = gate.hook();
  constexpr int kJobs = 300;  // fits into the working memory of one client
  std::vector<std::string> jobs;
  for (int k = 0; k < kJobs; ++k)
    jobs.push_back(server.post("/fracture?seed=" + std::to_string(k), "mesh", kAsync).header("location"));
  gate.wait_for(1);
  const nlohmann::json all = server.get("/jobs?limit=100").json().at("jobs"),
                       few = server.get("/jobs").json().at("jobs");
  ASSERT_EQ(all.size(), 100u);
  for (int k = 0; k < 100; ++k)
    EXPECT_EQ(all[static_cast<std::size_t>(k)].at("queue_position"), kJobs - 2 - k);
  ASSERT_EQ(few.size(), 20u);
  EXPECT_EQ(few[19].at("queue_position"), kJobs - 2 - 19);
  EXPECT_EQ(server.get(jobs.back()).json().at("queue_position"), kJobs - 2);
  for (const std::string& job : jobs) ask(server.port(), "DELETE", job);
  gate.open = true;
}

TEST(IoTurns, ABodyInChunksIsKeptInNoMoreThanItTakes) {
  TestServerOptions options;
  options.limits.max_bodies =
      options.limits.max_body / 2;  // room for this body, but not for the largest that is allowed
  TestServer server(options);
  const auto send = [&](std::size_t size, std::size_t chunk) {
    std::string wire = "POST /meshes HTTP/1.1\r\nHost: a\r\n" + kOfGlb + "Transfer-Encoding: chunked\r\n\r\n",
                body(size, 'x');
    char length[32];
    for (std::size_t at = 0; at < size; at += chunk) {
      std::snprintf(length, sizeof length, "%zx\r\n", std::min(chunk, size - at));
      wire += length + body.substr(at, chunk) + "\r\n";
    }
    RawClient client(server.port());
    client.send(wire + "0\r\n\r\n");
    return client.receive()->status;
  };
  EXPECT_EQ(send(300'000, 50'000), 201);
  EXPECT_LT(server.api.meshes().figures().bytes, 330'000u) << "and not the largest body that there may be";
  EXPECT_EQ(send(2'000, 1), 201) << "thousands of parts";
}

TEST(IoTurns, ATrailerHasFewFields) {
  TestServer server;
  const auto send = [&](std::size_t fields) {
    std::string wire = "POST /fracture HTTP/1.1\r\nHost: a\r\n" + kOfGlb +
                       "Transfer-Encoding: chunked\r\n\r\n6\r\na mesh\r\n0;a=b\r\n";
    for (std::size_t k = 0; k < fields; ++k) wire += "a:\r\n";
    RawClient client(server.port());
    client.send(wire + "\r\nGET /version HTTP/1.1\r\nHost: a\r\n\r\n");
    return client.receive()->status;
  };
  EXPECT_EQ(send(0), 200);
  EXPECT_EQ(send(http::kMaxFields), 200);
  EXPECT_EQ(send(http::kMaxFields + 1), 431);
  EXPECT_EQ(send(10'000), 431);
}

TEST(IoTurns, AreMeasured) {
  TestServer server;
  const auto turns = [&] {
    return parse_exposition(
        ask(server.server.admin_port(), "GET", "/metrics").body)["fracture_io_turn_seconds_count"];
  };
  server.get("/version");
  double before = 0;
  EXPECT_TRUE(eventually(kPatience, "no further turns: those of the admin listener are not counted",
                         [&] { return std::exchange(before, turns()) == turns() && before > 0; }));
  server.get("/version");
  EXPECT_TRUE(eventually(kPatience, "further turns", [&] { return turns() > before; }));
  EXPECT_EQ(parse_exposition(
                ask(server.server.admin_port(), "GET", "/metrics").body)["fracture_io_bulk_turns_total"],
            0);
}

}  // namespace
}  // namespace fracture::test
