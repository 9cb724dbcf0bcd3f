// Names in a token file: what each may request, and how often.
#include <gmock/gmock.h>

#include "tests/server/http/with_tenants.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/tenant_file.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

TEST(TenantAccess, AScopeOpensItsRoutesAndNoOther) {
  TestServer server(with_tenants({tenant("reader", {"read"}), tenant("breaker", {"fracture"}),
                                  tenant("baker", {"bake"}), tenant("boss", {"admin"})}));
  const std::string id = "sha256:" + sha256(std::string_view("a mesh")).hex();
  const std::string async = "Prefer: respond-async\r\n";
  struct Case {
    const char *method, *target;
    std::string fields, body;
    std::vector<std::string> may;
  };
  const std::vector<std::string> all = {"reader", "breaker", "baker", "boss"};
  const Case cases[] = {
      {"GET", "/version", "", "", all},
      {"HEAD", "/limits", "", "", all},
      {"GET", "/problems/forbidden", "", "", all},
      {"POST", "/fracture", kObj, "a mesh", {"breaker"}},
      {"POST", "/fracture", kObj + async, "a mesh", {"baker"}},
      {"PUT", "/meshes/", kObj, "a mesh", {"breaker", "baker"}},
      {"POST", "/meshes", kObj, "a mesh", {"breaker", "baker"}},
      {"GET", "/meshes/", "", "", {"reader"}},
      {"GET", "/jobs", "", "", {"reader"}},
      {"GET", "/jobs/0", "", "", {"reader"}},
      {"GET", "/jobs/0/events", "", "", {"reader"}},
      {"GET", "/fractures/sha256:0", "", "", {"reader"}},
      {"DELETE", "/jobs/0", "", "", {"baker", "boss"}},
      {"DELETE", "/meshes/", "", "", {"breaker", "baker", "boss"}},
  };
  for (const Case& c : cases)
    for (const std::string& name : all) {
      const std::string target = std::string(c.target) == "/meshes/" ? "/meshes/" + id : c.target;
      const Reply reply = ask(server.port(), c.method, target, c.fields + by(name), c.body);
      const bool may = std::find(c.may.begin(), c.may.end(), name) != c.may.end();
      EXPECT_EQ(reply.status == 403, !may) << c.method << " " << target << " " << name << " " << reply.status;
      if (!may) {
        EXPECT_EQ(reply.problem(), "forbidden");
        EXPECT_NE(reply.header("www-authenticate").find("insufficient_scope"), std::string::npos);
      }
    }
  EXPECT_EQ(server.get("/nothing", by("reader")).status, 404);
  EXPECT_EQ(server.get("/problems/unauthorized").status, 200) << "for those who have no token";
}

TEST(TenantAccess, ATokenThatHasExpiredIsRefusedAndItsSuccessorIsNot) {
  nlohmann::json studio = tenant("studio");
  studio["tokens"][0]["expires"] = "2001-01-01T00:00:00Z";
  studio["tokens"].push_back(
      {{"sha256", sha256(std::string_view(token_of("next"))).hex()}, {"expires", "2999-01-01T00:00:00Z"}});
  TestServer server(with_tenants({studio}));
  const Reply reply = server.get("/version", by("studio"));
  EXPECT_EQ(reply.status, 401);
  EXPECT_NE(reply.body.find("expired"), std::string::npos);
  EXPECT_NE(reply.header("www-authenticate").find("invalid_token"), std::string::npos);
  EXPECT_EQ(server.get("/version", by("next")).status, 200);
}

TEST(TenantAccess, OverItsRequestsANameGets429WithTheTimeAndOthersAreServed) {
  TestServer server(
      with_tenants({tenant("greedy", {"read"}, {{"requests_per_second", 0.01}}), tenant("quiet")}));
  const Reply first = server.get("/version", by("greedy"));
  EXPECT_EQ(first.status, 200);
  EXPECT_EQ(first.header("ratelimit-policy"), "\"requests\";q=1;w=100");
  EXPECT_EQ(first.header("ratelimit"), "\"requests\";r=0;t=100");
  const Reply second = server.get("/version", by("greedy"));
  EXPECT_EQ(second.status, 429);
  EXPECT_EQ(second.problem(), "over-share");
  EXPECT_GT(std::stoi(second.header("retry-after")), 90);
  EXPECT_NE(second.header("ratelimit"), "");
  const Reply other = server.get("/version", by("quiet"));
  EXPECT_EQ(other.status, 200);
  EXPECT_EQ(other.header("ratelimit"), "") << "no limit, no field";
}

TEST(TenantAccess, UsageStandsByNameInTheMetrics) {
  TestServer server(
      with_tenants({tenant("greedy", {"read"}, {{"requests_per_second", 0.01}}), tenant("quiet")}));
  server.get("/version", by("greedy"));
  server.get("/version", by("greedy"));
  server.post("/fracture", "a mesh", kObj + by("quiet"));
  // A request is counted a moment after its client has received the answer.
  for (const char* line : {"fracture_tenant_requests_total{tenant=\"greedy\"} 2",
                           "fracture_tenant_over_share_total{tenant=\"greedy\"} 1",
                           "fracture_tenant_requests_total{tenant=\"quiet\"} 1",
                           "fracture_tenant_body_bytes_total{tenant=\"quiet\",direction=\"in\"} 6"})
    EXPECT_TRUE(eventually(kPatience, line, [&] {
      return ask(server.server.admin_port(), "GET", "/metrics").body.find(line) != std::string::npos;
    }));
}

TEST(TenantAccess, TheMetricsOfManyNamesAreBounded) {
  std::vector<nlohmann::json> tenants;
  for (int k = 0; k < 150; ++k) tenants.push_back(tenant(std::string("n").append(std::to_string(1000 + k))));
  TestServer server(with_tenants(tenants));
  server.get("/version", by("n1000"));
  server.get("/version", by("n1149"));
  server.get("/version", by("n1148"));
  const std::string text = ask(server.server.admin_port(), "GET", "/metrics").body;
  std::size_t series = 0;
  for (std::size_t at = 0; (at = text.find("fracture_tenant_requests_total{", at)) != std::string::npos; ++at)
    ++series;
  EXPECT_EQ(series, 101u);
  EXPECT_NE(text.find("fracture_tenant_requests_total{tenant=\"all others\"} 2"), std::string::npos);
}

}  // namespace
}  // namespace fracture::test
