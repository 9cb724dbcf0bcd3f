// /metrics: what it counts, and that a scraper can read it.
#include <gtest/gtest.h>

#include <latch>
#include <thread>

#include "server/http/tenant_metrics.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

Exposition metrics(TestServer& server) {
  const Reply reply = ask(server.server.admin_port(), "GET", "/metrics");
  EXPECT_EQ(reply.status, 200);
  EXPECT_EQ(reply.header("content-type"), "text/plain; version=0.0.4; charset=utf-8");
  return parse_exposition(reply.body);
}

/// A request is counted after its answer has been written, so this waits until `family` has reached `value`.
Exposition metrics_when(TestServer& server, const std::string& family, const std::string& label,
                        double value) {
  Exposition m;
  EXPECT_TRUE(eventually(kPatience, family, [&] {
    m = metrics(server);
    return m.sum(family, label) >= value;
  }));
  return m;
}

TEST(Metrics, RequestsAreCountedByRouteAndStatus) {
  TestServer server;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(server.get("/version").status, 200);
  EXPECT_EQ(server.post("/fracture", "a mesh").status, 200);
  EXPECT_EQ(server.post("/fracture", "a mesh").status, 200);
  EXPECT_EQ(server.post("/fracture?sites=0").status, 400);
  EXPECT_EQ(server.get("/nothing/" + std::string(500, 'x')).status, 404);
  RawClient broken(server.port());
  broken.send("nonsense\r\n\r\n");
  EXPECT_EQ(broken.receive()->status, 400);

  const Exposition m = metrics_when(server, "fracture_requests_total", "public", 8);
  const auto requests = [&m](const std::string& route, int status) {
    return m["fracture_requests_total{listener=\"public\",route=\"" + route + "\",status=\"" +
             std::to_string(status) + "\"}"];
  };
  EXPECT_EQ(requests("/version", 200), 3);
  EXPECT_EQ(requests("/fracture", 200), 2);
  EXPECT_EQ(requests("none", 404), 1);
  EXPECT_EQ(requests("none", 400), 2) << "what was refused by its header alone has no route";
  EXPECT_EQ(m.sum("fracture_requests_total", "public"), 8);
  EXPECT_EQ(m["fracture_request_duration_seconds_count{route=\"/fracture\"}"], 2);
  EXPECT_EQ(m["fracture_queue_wait_seconds_count"], 1) << "what is in memory waits for nobody";
  EXPECT_EQ(m["fracture_connections_total"], 8);
  EXPECT_EQ(m["fracture_body_bytes_total{direction=\"in\"}"], 2 * 6);
  EXPECT_EQ(m["fracture_cache_lookups_total{cache=\"result\",outcome=\"miss\"}"], 1);
  EXPECT_EQ(m["fracture_cache_lookups_total{cache=\"result\",outcome=\"hit\"}"], 1);
  EXPECT_EQ(m["fracture_cache_lookups_total{cache=\"mesh\",outcome=\"miss\"}"], 1);
  EXPECT_GT(m.sum("fracture_cache_bytes", "result"), 0);
  EXPECT_EQ(m["fracture_ready"], 1);
  EXPECT_EQ(m.types.at("fracture_requests_total"), "counter");
  EXPECT_EQ(m.types.at("fracture_request_duration_seconds"), "histogram");
  EXPECT_EQ(m.types.at("fracture_queue_depth"), "gauge");
}

TEST(Metrics, ADurationIsInEveryBucketAboveIt) {
  TestServer server;
  server.get("/version");
  const Exposition m = metrics_when(server, "fracture_requests_total", "/version", 1);
  double last = 0;
  int buckets = 0;
  for (const auto& [name, value] : m.samples)
    if (name.rfind("fracture_request_duration_seconds_bucket{route=\"/version\"", 0) == 0) {
      ++buckets;
      last = std::max(last, value);
    }
  EXPECT_EQ(buckets, 19) << "18 bounds and infinity";
  EXPECT_EQ(last, 1);
  EXPECT_EQ(m["fracture_request_duration_seconds_bucket{route=\"/version\",le=\"+Inf\"}"], 1);
}

TEST(Metrics, QueueAndMemoryAreShownWhileTheyAreInUse) {
  TestServerOptions options;
  options.threads = 1;
  TestServer server(options);
  std::latch release(1);
  server.control->during_cut = [&](const Execution&) { release.wait(); };
  std::vector<std::thread> clients;
  for (int i = 0; i < 3; ++i)
    clients.emplace_back(
        [&, i] { EXPECT_EQ(server.post("/fracture?seed=" + std::to_string(i), "seven b").status, 200); });
  require_eventually(kPatience, "one to leave the queue", [&] { return server.control->cuts > 0; });
  const Exposition m = metrics_when(server, "fracture_queue_depth", "", 2);
  EXPECT_EQ(m["fracture_queue_depth"], 2);
  EXPECT_EQ(m["fracture_jobs_running"], 1);
  EXPECT_EQ(m["fracture_compute_threads"], 1);
  EXPECT_EQ(m["fracture_connections"], 3);
  EXPECT_EQ(m["fracture_requests_in_progress"], 3);
  EXPECT_EQ(server.api.bodies().whole().used(), 2 * 7u) << "the mesh of the one that runs has been imported";
  release.count_down();
  for (std::thread& client : clients) client.join();
}

TEST(Metrics, NoNameIsTakenForTheSumOfOthers) {
  TestServerOptions options;
  std::string file = "other 0123456789abcdef-0\nall 0123456789abcdef-1\n";
  for (std::size_t k = 0; k < http::kNamesInMetrics; ++k)
    file += "name" + std::to_string(k) + " 0123456789abcdef-name" + std::to_string(k) + "\n";
  options.server.tokens = *tenants::TokenFile::parse(file);
  TestServer server(options);
  const Exposition m = metrics(server);  // throws if a name is repeated
  std::size_t names = 0;
  for (const auto& [sample, value] : m.samples)
    names += sample.starts_with("fracture_tenant_requests_total{");
  EXPECT_EQ(names, http::kNamesInMetrics + 1);
  EXPECT_EQ(m.samples.count("fracture_tenant_requests_total{tenant=\"all others\"}"), 1u);
}

TEST(Metrics, RefusedConnectionsAndAbandonedWorkAreCounted) {
  TestServerOptions options;
  options.limits.max_connections_per_address = 1;
  TestServer server(options);
  server.control->during_cut = [](const Execution& execution) {
    require_eventually(kPatience, "the cancellation", [&] {
      execution.poll();
      return false;
    });
  };
  RawClient busy(server.port());
  busy.send("POST /fracture HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: 4\r\n\r\nmesh");
  require_eventually(kPatience, "a cut to begin", [&] { return server.control->cuts > 0; });
  RawClient second(server.port());
  EXPECT_EQ(second.receive()->status, 429);
  busy.reset();
  const Exposition m = metrics_when(server, "fracture_work_abandoned_total", "", 1);
  EXPECT_EQ(m["fracture_work_abandoned_total"], 1);
  EXPECT_EQ(m["fracture_connections_refused_total{reason=\"address\"}"], 1);
  EXPECT_EQ(m["fracture_connections_refused_total{reason=\"full\"}"], 0);
}

TEST(Metrics, AreNotOnThePublicListener) {
  TestServer server;
  EXPECT_EQ(server.get("/metrics").status, 404);
}

TEST(Metrics, DrainingShows) {
  TestServer server;
  server.api.set_draining();
  EXPECT_EQ(metrics(server)["fracture_ready"], 0);
}

}  // namespace
}  // namespace fracture::test
