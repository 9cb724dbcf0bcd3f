// Names and addresses that share a server: the share of each, and the effect on the others.
#include <algorithm>
#include <map>

#include "common/digest/digest.hpp"
#include "tests/attacks/attack.hpp"
#include "tests/attacks/bodies.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/proxies.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/tenant_file.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// A server with these tokens. A server program without shares gets a plain line for each token.
struct TenantAttack : testing::Test {
  const TemporaryFolder folder;
  std::unique_ptr<ServeProcess> server;

  void start(const std::vector<json>& tenants, std::vector<std::string> more = {}) {
    write(tenants);
    more.insert(more.end(), {"--memory", "4GiB", "--token-file", folder / "tokens"});
    server = std::make_unique<ServeProcess>(more);
  }
  void write(const std::vector<json>& tenants) {
    std::string text = tenant_file(tenants);
    if (!knows_shares()) {  // an older program reads only plain lines
      text.clear();
      for (const json& each : tenants)
        text += each.at("name").get<std::string>() + " " + token_of(each.at("name")) + "\n";
    }
    folder.write("tokens", text);
  }
  Reply post(const std::string& target, const std::string& name, const std::string& fields = kObj,
             const std::string& body = kCube) {
    return ask(server->port, "POST", target, fields + by(name), body);
  }
  void end() {
    ASSERT_TRUE(server->alive());
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(), 0);
  }
};

TEST_F(TenantAttack, RequestsOverTheRate) {
  start({tenant("greedy", {"read", "fracture"}, {{"requests_per_second", 2}}), tenant("quiet")});
  std::map<int, int> statuses;
  bool told = true;
  for (int k = 0; k < 40; ++k) {
    const Reply reply = post("/fracture?sites=4", "greedy");
    ++statuses[reply.status];
    told &= !reply.header("ratelimit-policy").empty() && !reply.header("ratelimit").empty();
    if (reply.status == 429) told &= reply.problem() == "over-share" && !reply.header("retry-after").empty();
    EXPECT_EQ(post("/fracture?sites=4", "quiet").status, 200);
  }
  EXPECT_TRUE(told) << "RateLimit on every answer, Retry-After on 429";
  EXPECT_GT(statuses[429], 0);
  EXPECT_GT(statuses[200], 0);
  EXPECT_EQ(statuses[200] + statuses[429], 40);
  report("RequestsOverTheRate",
         std::to_string(statuses[200]) + " served, " + std::to_string(statuses[429]) +
             " times 429 with Retry-After; the other name: 40 of 40 served",
         "no names, no shares");
  end();
}

TEST_F(TenantAttack, ComputationsAndBytesOverTheShare) {
  start({tenant("greedy", {"read", "fracture", "bake"},
                {{"computations", 2}, {"stored_bytes", 100'000}, {"cached_bytes", 200'000}}),
         tenant("quiet")});
  // Long jobs. The third is over the share.
  int running = 0, refused = 0;
  std::vector<std::string> jobs;
  for (int k = 0; k < 6; ++k) {
    const Reply reply =
        post("/fracture?sites=8000&lloyd=50&seed=" + std::to_string(k), "greedy", kObj + kRespondAsync);
    running += reply.status == 202;
    refused += reply.status == 429;
    if (reply.status == 202) jobs.push_back(reply.header("location"));
  }
  EXPECT_EQ(running, 2);
  EXPECT_EQ(refused, 4);
  EXPECT_EQ(post("/fracture?sites=4&seed=99", "quiet", kObj + "Priority: u=0\r\n").status, 200);
  for (const std::string& job : jobs) ask(server->port, "DELETE", job, by("greedy"));
  const std::string large = kCube + std::string(200'000, '#');
  const int stored = post("/meshes", "greedy", kObj, large).status,
            by_other = post("/meshes", "quiet", kObj, large).status;
  EXPECT_EQ(stored, 413);
  EXPECT_EQ(by_other, 201);
  EXPECT_TRUE(eventually(kPatience, "the jobs to be gone",
                         [&] { return post("/fracture?sites=4&seed=1", "greedy").status == 200; }));
  int there = 0;
  std::vector<std::string> answers;
  for (int seed = 0; seed < 8; ++seed) {
    const Reply made = post("/fracture?sites=12&seed=" + std::to_string(seed), "greedy");
    EXPECT_EQ(made.status, 200) << made.body;
    answers.push_back(made.header("content-location"));
  }
  std::size_t bytes = 0;
  for (const std::string& answer : answers) {
    const Reply again = ask(server->port, "GET", answer, by("greedy"));
    there += again.status == 200;
    if (again.status == 200) bytes += again.body.size();
  }
  EXPECT_LE(bytes, 200'000u);
  EXPECT_LT(there, 8);
  report("ComputationsAndBytesOverTheShare",
         "6 jobs at once: " + std::to_string(running) + " taken, " + std::to_string(refused) +
             " times 429; a mesh over stored_bytes: " + std::to_string(stored) + "; of 8 answers " +
             std::to_string(there) + " kept, " + std::to_string(bytes) + " bytes of 200000",
         "no names, no shares");
  end();
}

TEST_F(TenantAttack, ComputationsThatSeveralWaitFor) {
  start({tenant("ana"), tenant("bob"), tenant("cyd")});
  const auto charged = [&](const std::string& name) {
    return parse_exposition(ask(server->admin_port, "GET", "/metrics").body)
        .sum("fracture_tenant_processor_seconds_total", "tenant=\"" + name + "\"");
  };
  const std::string target = "/fracture?sites=4000&lloyd=10";
  std::vector<std::thread> clients;
  for (const char* name : {"ana", "bob", "bob", "bob"})
    clients.emplace_back([&, name] { EXPECT_EQ(post(target, name).status, 200); });
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(post(target, "cyd").status, 200);
  const double ana = charged("ana"), bob = charged("bob"), cyd = charged("cyd");
  EXPECT_GT(ana, 0);
  EXPECT_LE(bob, 1.2 * ana + 0.05) << "asking three times is paid once";
  EXPECT_GE(bob, 0.8 * ana - 0.05);
  EXPECT_LE(cyd, 0.2 * ana + 0.05) << "from the cache";
  char text[160];
  std::snprintf(text, sizeof text,
                "charged: ana %.2f s, bob (three times) %.2f s, cyd (from the cache) %.2f s", ana, bob, cyd);
  report("ComputationsThatSeveralWaitFor", text, "nobody was charged");
  end();
}

// Reloads under load: a removed name is refused at once, a broken file changes nothing, and no other client
// notices.
TEST_F(TenantAttack, ReloadUnderLoad) {
  start({tenant("ana"), tenant("bob")}, {"--log-format", "json"});
  std::atomic<bool> stop{false};
  std::atomic<int> served{0}, failed{0};
  std::thread load([&] {
    for (int seed = 0; !stop; ++seed) {
      try {
        ++(post("/fracture?sites=4&seed=" + std::to_string(seed), "ana").status == 200 ? served : failed);
      } catch (const std::runtime_error&) {
        ++failed;
      }
    }
  });
  const auto status = [&](const std::string& name) {
    try {
      return ask(server->port, "GET", "/version", by(name)).status;
    } catch (const std::runtime_error&) {
      return 0;
    }
  };
  for (int round = 0; round < 5; ++round) {
    write({tenant("ana")});
    server->signal(SIGHUP);
    EXPECT_TRUE(
        eventually(std::chrono::seconds(20), "bob to be nobody", [&] { return status("bob") == 401; }));
    folder.write("tokens", "{\"tenants\": [{\"name\": \"mallory\"}");
    server->signal(SIGHUP);
    EXPECT_NE(server->error_line_with("stay in force"), "");
    EXPECT_EQ(status("ana"), 200);
    write({tenant("ana"), tenant("bob")});
    server->signal(SIGHUP);
    EXPECT_TRUE(eventually(std::chrono::seconds(20), "bob to be back", [&] { return status("bob") == 200; }));
    if (testing::Test::HasFailure()) break;
  }
  stop = true;
  load.join();
  EXPECT_EQ(failed, 0);
  EXPECT_GT(served, 0);
  report("ReloadUnderLoad",
         "15 reloads, 5 of a broken file; " + std::to_string(served) + " served meanwhile, " +
             std::to_string(failed) + " failed",
         "SIGHUP ended the process");
  end();
}

// -- a digest is not an access token, directly and through proxies

struct TenantWay : TenantAttack, testing::WithParamInterface<std::string> {};

TEST_P(TenantWay, DigestsAreNoAccessTokens) {
  start({tenant("ana"), tenant("bob"), tenant("boss", {"read", "bake", "admin"})});
  std::unique_ptr<Proxy> proxy;
  if (GetParam() != "Direct") {
    const auto kind = GetParam() == "Haproxy" ? Proxy::Kind::kHaproxy : Proxy::Kind::kNginx;
    if (!Proxy::installed(kind)) GTEST_SKIP() << GetParam() << " is not installed";
    proxy = std::make_unique<Proxy>(kind, server->port);
  }
  const std::uint16_t port = proxy ? proxy->port : server->port;
  const auto get = [&](const std::string& method, const std::string& target, const std::string& name,
                       const std::string& fields = "", const std::string& body = "") {
    return ask(port, method, target, fields + by(name), body);
  };
  const std::string mesh = "/meshes/sha256:" + sha256(std::string_view(kCube)).hex();
  EXPECT_EQ(get("PUT", mesh, "ana", kObj, kCube).status, 201);
  const Reply made = get("POST", mesh + "/fracture", "ana", kJson, R"({"sites": 5})");
  ASSERT_EQ(made.status, 200) << made.body;
  const std::string answer = made.header("content-location");
  const Reply started = get("POST", mesh + "/fracture", "ana", kJson + kRespondAsync, R"({"sites": 6})");
  ASSERT_EQ(started.status, 202) << started.body;
  const std::string job = started.header("location");

  int tried = 0, hidden = 0;
  const auto nothing = [&](const Reply& reply, const char* what) {
    ++tried;
    hidden += reply.status == 404;
    EXPECT_EQ(reply.status, 404) << what << ": " << reply.body.substr(0, 300);
  };
  nothing(get("GET", mesh, "bob"), "the mesh");
  nothing(get("HEAD", mesh, "bob"), "the mesh");
  nothing(get("DELETE", mesh, "bob"), "the mesh");
  nothing(get("POST", mesh + "/fracture", "bob", kJson, R"({"sites": 5})"), "its fracture");
  nothing(get("POST", "/fracture", "bob", kJson, R"({"mesh": ")" + mesh.substr(8) + R"("})"), "by name");
  nothing(get("GET", answer, "bob"), "the answer");
  nothing(get("GET", answer, "bob", "If-None-Match: " + made.header("etag") + "\r\n"), "whether it is there");
  nothing(get("GET", answer, "bob", "Range: bytes=0-9\r\n"), "a part of it");
  nothing(get("GET", job, "bob"), "the job");
  nothing(get("GET", job + "/events", "bob"), "its events");
  nothing(get("DELETE", job, "bob"), "cancelling it");
  EXPECT_EQ(get("GET", answer, "boss").status, 200);
  EXPECT_EQ(get("GET", answer, "ana").header("cache-control").substr(0, 7), "private");

  EXPECT_EQ(get("PUT", mesh, "bob", kObj, kCube).status / 100, 2) << "now it is bob's, too";
  nothing(get("POST", mesh + "/fracture", "bob", kJson, R"({"of": ")" + answer + R"(", "physics": "none"})"),
          "of");
  EXPECT_EQ(get("DELETE", mesh, "ana").status, 204);
  EXPECT_EQ(get("GET", mesh, "ana").status, 404);
  EXPECT_EQ(get("GET", mesh, "bob").status, 200) << "equal uploads have two owners";
  report("DigestsAreNoAccessTokens" + GetParam(),
         std::to_string(hidden) + " of " + std::to_string(tried) + " addresses of another name are 404",
         "who knew a digest had the mesh, the answer and the job");
  end();
}

INSTANTIATE_TEST_SUITE_P(Ways, TenantWay, testing::Values("Direct", "Haproxy", "Nginx"),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace fracture::test
