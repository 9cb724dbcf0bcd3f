// GET /jobs: the newest job first, in pages, and each name's own jobs.
#include <gtest/gtest.h>

#include "tests/server/support/job_server.hpp"
#include "tests/server/support/tenant_file.hpp"

namespace fracture::test {
namespace {

std::vector<std::string> ids_in(const nlohmann::json& document) {
  std::vector<std::string> ids;
  for (const auto& job : document.at("jobs")) ids.push_back(job.at("links").at("self"));
  return ids;
}

struct Listed : testing::Test {
  TestServer server;
  std::vector<std::string> jobs;  // the newest first
  void SetUp() override {
    for (int seed = 0; seed < 5; ++seed) {
      jobs.insert(jobs.begin(),
                  server.post("/fracture?seed=" + std::to_string(seed), "mesh", kAsync).header("location"));
      wait_for_state(server, jobs.front(), "done");
    }
  }
};

TEST_F(Listed, TheNewestComesFirst) {
  const Reply reply = server.get("/jobs");
  EXPECT_EQ(reply.status, 200);
  EXPECT_EQ(ids_in(reply.json()), jobs);
  EXPECT_FALSE(reply.json().contains("next"));
  EXPECT_EQ(reply.json().at("jobs").at(0), server.get(jobs.front()).json());
}

TEST_F(Listed, PagesFollowEachOtherWithoutGapOrRepetition) {
  std::vector<std::string> all;
  std::string page = "/jobs?limit=2";
  for (int pages = 0; !page.empty(); ++pages) {
    ASSERT_LT(pages, 4);
    const Reply reply = server.get(page);
    ASSERT_EQ(reply.status, 200) << page;
    const auto ids = ids_in(reply.json());
    EXPECT_LE(ids.size(), 2u);
    all.insert(all.end(), ids.begin(), ids.end());
    page = reply.json().value("next", "");
    EXPECT_EQ(reply.header("link"), page.empty() ? "" : "<" + page + ">; rel=\"next\"");
    // A job that vanishes or arrives between two pages does not affect the others.
    if (pages == 0) {
      EXPECT_EQ(ask(server.port(), "DELETE", jobs[1]).status, 204);
      server.post("/fracture?seed=99", "mesh", kAsync);
    }
  }
  EXPECT_EQ(all, jobs);
}

TEST_F(Listed, AStateFilters) {
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string running = server.post("/fracture?seed=50", "mesh", kAsync).header("location");
  wait_for_state(server, running, "running");
  EXPECT_EQ(ids_in(server.get("/jobs?state=running").json()), std::vector{running});
  EXPECT_EQ(ids_in(server.get("/jobs?state=done&limit=2").json()), (std::vector{jobs[0], jobs[1]}));
  EXPECT_NE(server.get("/jobs?state=done&limit=2").json().at("next").get<std::string>().find("state=done"),
            std::string::npos);
  EXPECT_TRUE(ids_in(server.get("/jobs?state=failed").json()).empty());
  gate.open = true;
  wait_for_state(server, running, "done");
}

TEST_F(Listed, WhatIsNoPageIsRefusedByName) {
  for (const char* query : {"limit=0", "limit=101", "limit=x", "state=over", "before=yesterday",
                            "before=2026-13-01T00:00:00.000000Z", "limit=1&limit=2"}) {
    const Reply reply = server.get(std::string("/jobs?") + query);
    EXPECT_EQ(reply.status, 400) << query;
    EXPECT_EQ(reply.problem(), "bad-parameter") << query;
  }
  EXPECT_EQ(server.get("/jobs?order=oldest").problem(), "unknown-parameter");
  EXPECT_EQ(ask(server.port(), "DELETE", "/jobs").status, 405);
}

TEST(JobsList, ANameSeesItsOwnAndAnAdministratorAll) {
  TestServerOptions options;
  options.server.tokens = *tenants::TokenFile::parse(
      tenant_file({tenant("ana"), tenant("bob"), tenant("boss", {"read", "admin"})}));
  TestServer server(options);
  const std::string anas = server.post("/fracture?seed=1", "mesh", kAsync + by("ana")).header("location");
  const std::string bobs = server.post("/fracture?seed=2", "mesh", kAsync + by("bob")).header("location");
  EXPECT_EQ(ids_in(server.get("/jobs", by("ana")).json()), std::vector{anas});
  EXPECT_EQ(ids_in(server.get("/jobs", by("bob")).json()), std::vector{bobs});
  EXPECT_EQ(ids_in(server.get("/jobs", by("boss")).json()), (std::vector{bobs, anas}));
  EXPECT_EQ(server.get("/jobs").status, 401);
}

}  // namespace
}  // namespace fracture::test
