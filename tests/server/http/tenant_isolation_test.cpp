// A digest is not an access token: whatever one name has made or uploaded is hidden from another, under every
// address. Without names everything stays shared.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/server/http/with_tenants.hpp"
#include "tests/server/support/gzip.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/tenant_file.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

struct Isolation : testing::Test {
  TestServer server{with_tenants({tenant("ana"), tenant("bob"), tenant("boss", {"read", "bake", "admin"})})};
  const std::string id = "sha256:" + sha256(std::string_view("a mesh")).hex();

  int status(const std::string& method, const std::string& target, const std::string& name,
             const std::string& fields = "") {
    return ask(server.port(), method, target, fields + by(name)).status;
  }
  std::string put(const std::string& name) {
    EXPECT_EQ(server.put("/meshes/" + id, "a mesh", kObj + by(name)).status, 201);
    return "/meshes/" + id;
  }
  std::string finished_job(const std::string& name) {
    const Reply started = server.post("/fracture?seed=9", "a mesh", kObj + kRespondAsync + by(name));
    EXPECT_EQ(started.status, 202);
    const std::string job = started.header("location");
    EXPECT_TRUE(eventually(kPatience, "the job",
                           [&] { return server.get(job, by(name)).json().value("state", "") == "done"; }));
    return job;
  }
};

TEST_F(Isolation, AMeshIsThereForWhoStoredItAndForAnAdministrator) {
  const std::string mesh = put("ana");
  for (const char* method : {"GET", "HEAD"}) {
    EXPECT_EQ(status(method, mesh, "ana"), 200);
    EXPECT_EQ(status(method, mesh, "boss"), 200);
    EXPECT_EQ(status(method, mesh, "bob"), 404);
  }
  const std::string named = R"({"mesh": ")" + id + R"("})";
  EXPECT_EQ(server.post_json(mesh + "/fracture", "", by("bob")).status, 404);
  EXPECT_EQ(server.post_json("/fracture", named, by("bob")).status, 404);
  EXPECT_EQ(server.control->cuts, 0);
  EXPECT_EQ(server.post_json(mesh + "/fracture", "", by("ana")).status, 200);
  EXPECT_EQ(server.post_json("/fracture", named, by("ana")).status, 200);
  EXPECT_EQ(status("DELETE", mesh, "bob"), 404);
  EXPECT_EQ(status("GET", mesh, "ana"), 200);
  EXPECT_EQ(status("DELETE", mesh, "boss"), 204);
  EXPECT_EQ(status("GET", mesh, "ana"), 404);
}

TEST_F(Isolation, AnAnswerOfWhatIsNotThereTellsNothing) {
  put("ana");
  const std::string other = "sha256:" + sha256(std::string_view("another mesh")).hex();
  const Reply hidden = server.get("/meshes/" + id, by("bob")),
              absent = server.get("/meshes/" + other, by("bob"));
  // Each error repeats the id of its request. Everything else is equal.
  const auto without = [](std::string detail, const std::string& asked) {
    const std::size_t at = detail.find(asked);
    return at == std::string::npos ? detail : detail.erase(at, asked.size());
  };
  EXPECT_EQ(without(hidden.json().value("detail", "1"), id),
            without(absent.json().value("detail", "2"), other));
  EXPECT_EQ(hidden.headers.size(), absent.headers.size());
}

TEST_F(Isolation, EqualUploadsHaveTwoOwnersAndDeleteTakesAwayOne) {
  const std::string mesh = put("ana");
  put("bob");
  EXPECT_EQ(server.api.meshes().figures().meshes, 1u);
  EXPECT_EQ(status("DELETE", mesh, "ana"), 204);
  EXPECT_EQ(status("GET", mesh, "ana"), 404);
  EXPECT_EQ(status("GET", mesh, "bob"), 200);
}

TEST_F(Isolation, AnAnswerIsThereForWhoMadeIt) {
  const Reply made = server.post("/fracture", "a mesh", kObj + by("ana"));
  ASSERT_EQ(made.status, 200);
  EXPECT_EQ(made.header("cache-control"), "private");
  const std::string answer = made.header("content-location"), etag = made.header("etag");
  for (const char* method : {"GET", "HEAD"}) {
    EXPECT_EQ(status(method, answer, "ana"), 200);
    EXPECT_EQ(status(method, answer, "bob"), 404);
    EXPECT_EQ(status(method, answer, "bob", "If-None-Match: " + etag + "\r\n"), 404)
        << "not even whether it is";
    EXPECT_EQ(status(method, answer, "boss"), 200);
  }
  EXPECT_EQ(server.get(answer, by("ana")).header("cache-control"), "private, max-age=31536000, immutable");

  const Reply again = server.post("/fracture", "a mesh", kObj + by("bob"));
  EXPECT_EQ(again.status, 200);
  EXPECT_EQ(again.body, made.body);
  EXPECT_EQ(server.control->cuts, 1) << "who has the mesh may have the answer, made once";
  EXPECT_EQ(status("GET", answer, "bob"), 200);
}

TEST_F(Isolation, AnEarlierAnswerCanBeNamedOnlyByWhoMadeIt) {
  const Reply made = server.post("/fracture", "a mesh", kObj + by("ana"));
  const std::string of = made.header("content-location");
  put("bob");
  put("ana");
  const std::string body = R"({"of": ")" + of + R"(", "physics": "none"})";
  const std::string path = "/meshes/" + id + "/fracture";
  EXPECT_EQ(server.post_json(path, body, by("ana")).status, 200);
  const Reply refused = server.post_json(path, body, by("bob"));
  EXPECT_EQ(refused.status, 404);
  EXPECT_EQ(refused.problem(), "no-such-answer");
  const Reply form = server.post("/fracture?physics=none&of=" + of, "a mesh", kObj + by("bob"));
  EXPECT_EQ(form.problem(), "no-such-answer");
}

TEST_F(Isolation, AJobIsThereForWhoStartedIt) {
  const std::string job = finished_job("ana");
  const std::string result = server.get(job, by("ana")).json().value("result", "");
  EXPECT_EQ(status("GET", result, "ana"), 200);
  EXPECT_EQ(status("GET", result, "bob"), 404);
  for (const std::string& target : {job, job + "/events"})
    EXPECT_EQ(status("GET", target, "bob"), 404) << target;
  EXPECT_EQ(status("DELETE", job, "bob"), 404);
  EXPECT_EQ(status("GET", job, "boss"), 200);
  EXPECT_EQ(status("DELETE", job, "ana"), 204);
  EXPECT_EQ(status("GET", job, "ana"), 404);
}

TEST_F(Isolation, WhatANameHoldsStandsInTheMetrics) {
  put("ana");
  const Reply made = server.post("/fracture", "a mesh", kObj + by("ana"));
  const std::string text = ask(server.server.admin_port(), "GET", "/metrics").body;
  EXPECT_NE(text.find("fracture_tenant_answer_bytes{tenant=\"ana\"} " + std::to_string(made.body.size())),
            std::string::npos);
  EXPECT_NE(text.find("fracture_tenant_answer_bytes{tenant=\"bob\"} 0"), std::string::npos);
  EXPECT_EQ(text.find("fracture_tenant_stored_mesh_bytes{tenant=\"ana\"} 0\n"), std::string::npos);
}

TEST(Tenants, AnswersOverTheShareAreForgottenTheLeastRecentlyUsedFirst) {
  TestServerOptions options =
      with_tenants({tenant("ana", {"read", "fracture"}, {{"cached_bytes", 25'000}}), tenant("bob")});
  TestServer server(options);
  server.control->glb_padding = 10'000;
  std::vector<std::string> answers;
  for (int seed = 0; seed < 3; ++seed) {
    const Reply made = server.post("/fracture?seed=" + std::to_string(seed), "a mesh", kObj + by("ana"));
    answers.push_back(made.header("content-location"));
    if (seed == 1) {
      EXPECT_EQ(server.get(answers[0], by("ana")).status, 200);
    }
  }
  EXPECT_EQ(server.get(answers[0], by("ana")).status, 200);
  EXPECT_EQ(server.get(answers[1], by("ana")).status, 404);
  EXPECT_EQ(server.get(answers[2], by("ana")).status, 200);
  EXPECT_EQ(server.service.figures().results.entries, 2u) << "nobody could have it, so it is not kept";
}

TEST(Tenants, WhatWasMadeOfAForgottenAnswerIsForgottenWithIt) {
  TestServer server(
      with_tenants({tenant("ana", {"read", "fracture"}, {{"cached_bytes", 15'000}}), tenant("bob")}));
  server.control->glb_padding = 10'000;
  const std::string first =
      server.post("/fracture?seed=1", "a mesh", kObj + by("ana")).header("content-location");
  for (const char* coding : {"gzip", "zstd"})
    for (const char* form : {"model/gltf-binary", "application/json"})
      server.get(first,
                 by("ana") + "Accept-Encoding: " + coding + ", identity;q=0\r\nAccept: " + form + "\r\n");
  EXPECT_EQ(server.service.figures().results.entries, 5u) << "and four variants";
  server.post("/fracture?seed=2", "a mesh", kObj + by("ana"));
  EXPECT_EQ(server.service.figures().results.entries, 1u);
}

TEST(Tenants, TheLedgerIsBoundedAndWhoHasMostForgetsFirst) {
  TestServerOptions options = with_tenants({tenant("ana"), tenant("bob")});
  options.limits.answer_ledger = 5 * tenants::AnswerLedger::kBytesPerEntry;
  TestServer server(options);
  const auto made = [&](const std::string& name, int seed) {
    return server.post("/fracture?seed=" + std::to_string(seed), "a mesh", kObj + by(name))
        .header("content-location");
  };
  const std::string of_bob = made("bob", 100);
  std::vector<std::string> of_ana;
  for (int seed = 0; seed < 20; ++seed) of_ana.push_back(made("ana", seed));
  EXPECT_EQ(server.get(of_bob, by("bob")).status, 200);
  EXPECT_EQ(server.get(of_ana.back(), by("ana")).status, 200);
  EXPECT_EQ(server.get(of_ana[15], by("ana")).status, 404);
  EXPECT_EQ(server.api.ledger().held_bytes(), options.limits.answer_ledger);
  EXPECT_EQ(server.service.figures().results.entries, 5u) << "what nobody may see is not kept";
}

TEST(Tenants, AMeshOverTheShareIsRefused) {
  TestServer server(
      with_tenants({tenant("ana", {"read", "fracture"}, {{"stored_bytes", 20'000}}), tenant("bob")}));
  const std::string large(50'000, 'm');
  EXPECT_EQ(server.post("/meshes", large, kObj + by("ana")).status, 413);
  EXPECT_EQ(server.post("/meshes", large, kObj + by("bob")).status, 201);
  EXPECT_EQ(server.post("/meshes", "small", kObj + by("ana")).status, 201);
}

TEST(Tenants, ComputationsOverTheShareAre429AndTheOthersAreServed) {
  TestServer server(with_tenants({tenant("greedy", {"fracture"}, {{"computations", 1}}), tenant("quiet")}));
  std::atomic<bool> open{false};
  server.control->during_cut = [&](const Execution& execution) {
    while (!open) execution.poll();
  };
  RawClient first(server.port());
  first.send("POST /fracture HTTP/1.1\r\nHost: a\r\n" + kObj + by("greedy") +
             "Content-Length: 6\r\n\r\na mesh");
  EXPECT_TRUE(eventually(kPatience, "it to be computed", [&] { return server.control->cuts == 1; }));
  const Reply second = server.post("/fracture?seed=2", "a mesh", kObj + by("greedy"));
  EXPECT_EQ(second.status, 429);
  EXPECT_EQ(second.problem(), "over-share");
  EXPECT_GE(std::stoi(second.header("retry-after")), 1);
  RawClient other(server.port());
  other.send("POST /fracture?seed=3 HTTP/1.1\r\nHost: a\r\n" + kObj + by("quiet") +
             "Content-Length: 6\r\n\r\na mesh");
  EXPECT_TRUE(eventually(kPatience, "the other's", [&] { return server.control->cuts == 2; }));
  open = true;
  EXPECT_EQ(first.receive()->status, 200);
  EXPECT_EQ(other.receive()->status, 200);
}

TEST(Tenants, ARequestOfSeveralStepsHasOnePlaceAmongTheComputationsOfItsName) {
  TestServer server(with_tenants({tenant("ana", {"fracture"}, {{"computations", 1}})}));
  const std::string body = gzip(std::string(2u << 20, 'x'));
  const std::string fields = kObj + by("ana") + "Content-Encoding: gzip\r\nAccept-Encoding: zstd\r\n";
  for (int seed = 0; seed < 10; ++seed)  // decoded, computed, compressed; the next follows at once
    EXPECT_EQ(server.post("/fracture?seed=" + std::to_string(seed), body, fields).status, 200) << seed;
}

TEST(Tenants, AJobKeepsThePlaceThatItsBodyHadTaken) {
  TestServer server(with_tenants({tenant("ana", {"fracture", "bake"}, {{"computations", 1}})}));
  std::atomic<bool> open{false};
  server.control->during_cut = [&](const Execution& execution) {
    while (!open) execution.poll();
  };
  const std::string fields = kObj + by("ana") + "Content-Encoding: gzip\r\n";
  const std::string body = gzip(std::string(1u << 20, 'x'));
  EXPECT_EQ(server.post("/fracture", body, fields + "Prefer: respond-async\r\n").status, 202);
  EXPECT_EQ(server.post("/fracture?seed=2", body, fields).status, 429);
  open = true;
  EXPECT_TRUE(eventually(kPatience, "the end of the job",
                         [&] { return server.post("/fracture?seed=2", body, fields).status == 200; }));
}

TEST(Tenants, ANameWithoutRealtimeIsServedAsBatch) {
  TestServerOptions options =
      with_tenants({tenant("low", {"fracture"}, {{"priority", "batch"}}), tenant("high")});
  options.threads = 1;
  options.limits.realtime_deadline = std::chrono::hours(1);
  TestServer server(options);
  std::atomic<bool> open{false};
  std::mutex mutex;
  std::vector<std::uint32_t> order;
  server.control->import = [&](std::string_view mesh) -> Expected<Mesh> {
    require_eventually(kPatience, "the test to let the import go on", [&] { return open.load(); });
    const std::lock_guard lock(mutex);
    order.push_back(static_cast<std::uint32_t>(mesh.size()));
    return Mesh{};
  };
  std::vector<std::unique_ptr<RawClient>> clients;
  const auto send = [&](const std::string& name, std::size_t size) {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    clients.back()->send("POST /fracture HTTP/1.1\r\nHost: a\r\nPriority: u=0\r\n" + kObj + by(name) +
                         "Content-Length: " + std::to_string(size) + "\r\n\r\n" + std::string(size, 'm'));
    EXPECT_TRUE(eventually(kPatience, "it to wait",
                           [&] { return server.pool.running() + server.pool.queued() == clients.size(); }));
  };
  send("high", 1);
  send("low", 2);
  send("high", 3);
  open = true;
  for (const auto& client : clients) EXPECT_EQ(client->receive()->status, 200);
  EXPECT_EQ(order, (std::vector<std::uint32_t>{1, 3, 2}));
}

TEST(Tenants, NamesOfLinesAndNobodyAtAllShareEverything) {
  TestServerOptions lines;
  lines.server.tokens =
      *tenants::TokenFile::parse("ana " + token_of("ana") + "\nbob " + token_of("bob") + " read-only\n");
  TestServer server(lines), open;
  const Reply made = server.post("/fracture", "a mesh", kObj + by("ana"));
  EXPECT_EQ(server.get(made.header("content-location"), by("bob")).status, 200);
  EXPECT_EQ(server.get(made.header("content-location"), by("bob")).header("cache-control"),
            "private, max-age=31536000, immutable");
  EXPECT_EQ(server.post("/meshes", "a mesh", kObj + by("ana")).status, 201);
  EXPECT_EQ(server.get("/meshes/sha256:" + sha256(std::string_view("a mesh")).hex(), by("bob")).status, 200);
  const Reply anonymous = open.post("/fracture", "a mesh", kObj);
  EXPECT_EQ(anonymous.header("cache-control"), "");
  EXPECT_EQ(open.get(anonymous.header("content-location")).header("cache-control"),
            "public, max-age=31536000, immutable");
}

}  // namespace
}  // namespace fracture::test
