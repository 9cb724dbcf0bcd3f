// Evicting jobs for other clients: a client keeps its jobs if it has no more jobs than the new client.
#include <gtest/gtest.h>

#include "tests/server/support/job_server.hpp"
#include "tests/server/support/jobs_host.hpp"
#include "tests/server/support/tenant_file.hpp"

namespace fracture::test {
namespace {

using ErrorOf = std::optional<Error>;

struct Holders : testing::Test {
  static Terms of(const std::string& client) {
    Terms terms;
    terms.priority = Priority::kBackground;
    terms.deadline = far_off();
    terms.payer.flow = {client, 1};
    return terms;
  }
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  FractureService service{ServiceConfig{}, std::make_unique<FakeEngine>(control)};
  WorkerPool pool{2, 64};
  Dispatcher dispatcher{service, pool};
  std::optional<Jobs> jobs;

  void begin(std::size_t max_jobs, std::uint64_t max_result_bytes = 512u << 20) {
    JobsConfig config;
    config.max_jobs = max_jobs;
    config.max_result_bytes = max_result_bytes;
    jobs.emplace(dispatcher, config);
  }
  ErrorOf start(const std::string& client, std::uint64_t seed, std::string* id = nullptr) {
    return jobs->start(fracture_request("mesh", seed), of(client), {}, [id](const JobView& job) {
      if (id) *id = job.id;
    });
  }
  std::string started(const std::string& client, std::uint64_t seed) {
    std::string id;
    const ErrorOf refused = start(client, seed, &id);
    EXPECT_FALSE(refused) << refused->detail;
    dispatcher.wait_idle();
    return id;
  }
  void TearDown() override {
    if (jobs) jobs->stop();
    dispatcher.wait_idle();
  }
};

TEST_F(Holders, WhoHasMostGivesUpItsOldest) {
  begin(10);
  const std::string first = started("many", 0);
  std::vector<std::string> mine;
  for (std::uint64_t seed = 100; seed < 103; ++seed) mine.push_back(started("few", seed));
  for (std::uint64_t seed = 1; seed < 50; ++seed)
    started("many", seed % 5);  // the answers of most of them are known
  for (const std::string& job : mine) EXPECT_TRUE(jobs->find(job)) << job;
  EXPECT_FALSE(jobs->find(first));
  EXPECT_EQ(jobs->figures().jobs, 10u);
  EXPECT_EQ(jobs->figures().evicted, 50u - 7u);
  for (std::uint64_t seed = 103; seed < 107; ++seed) mine.push_back(started("few", seed));
  EXPECT_EQ(jobs->list({}, 100).size(), 10u);
  EXPECT_TRUE(jobs->find(mine[2])) << "it takes from who has more";
  started("third", 200);
  started("third", 201);
  EXPECT_EQ(jobs->figures().jobs, 10u);
}

/// However many clients have one job each, the next client finds a place: a client with two jobs gives one
/// up.
TEST_F(Holders, ManyThatHaveOneTakeNothingFromEachOtherButForWhoIsNew) {
  begin(10);
  const std::string mine = started("few", 1000);
  started("few", 1001);
  for (std::uint64_t client = 0; client < 8; ++client) started("client " + std::to_string(client), client);
  EXPECT_EQ(jobs->figures().evicted, 0u);
  started("one more", 2000);
  EXPECT_EQ(jobs->figures().evicted, 1u);
  EXPECT_FALSE(jobs->find(mine)) << "the older one of the two";
  const std::size_t before = jobs->figures().evicted;
  started("one more", 2001);  // It now has more than the others, so its own job is evicted.
  EXPECT_EQ(jobs->figures().evicted, before + 1);
  EXPECT_EQ(jobs->figures().jobs, 10u);
}

TEST_F(Holders, WhoHasMostGivesUpItsResults) {
  control->glb_padding = 1000;
  begin(100, 6000);
  const std::string mine = started("few", 1000);
  for (std::uint64_t seed = 0; seed < 20; ++seed) started("many", seed);
  EXPECT_TRUE(jobs->find(mine)->answer) << "and its result with it";
  EXPECT_LE(jobs->figures().result_bytes, 6000u);
  EXPECT_GT(jobs->figures().results_evicted, 10u);
  EXPECT_EQ(jobs->figures().jobs, 21u);
}

TEST_F(Holders, UnfinishedOnesOfOneClientLeavePlacesForOthers) {
  begin(10);
  Gate gate;
  control->during_cut = gate.hook();
  std::uint64_t seed = 0;
  int taken = 0;
  ErrorOf refused;
  while (taken < 20 && !(refused = start("many", seed++))) ++taken;
  ASSERT_TRUE(refused);
  EXPECT_EQ(taken, 4) << "three quarters of five, rounded up";
  EXPECT_EQ(refused->code, ErrorCode::kOverShare);
  EXPECT_GE(refused->retry_after.count(), 1);
  for (std::uint64_t client = 0; client < 6; ++client)
    EXPECT_FALSE(start("client " + std::to_string(client), 1000 + client));
  EXPECT_EQ(start("many", seed++)->code, ErrorCode::kOverShare);
  EXPECT_EQ(start("client 0", seed++)->code, ErrorCode::kOverShare);
  EXPECT_EQ(start("one more", seed++)->code, ErrorCode::kOverloaded) << "ten are unfinished";
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(jobs->figures().unfinished, 0u);
  for (int k = 0; k < 20; ++k) started("many", seed++);
  EXPECT_EQ(jobs->figures().jobs, 10u);
}

TEST_F(Holders, JobsThatAreRefusedOrCancelledAreCountedNoMore) {
  begin(4);
  Gate gate;
  control->during_cut = gate.hook();
  for (int round = 0; round < 5; ++round) {
    std::string id;
    ASSERT_FALSE(start("a", 10 + round, &id)) << round;
    EXPECT_TRUE(jobs->cancel(id));
    EXPECT_TRUE(eventually(kPatience, "it to be cancelled", [&] { return jobs->find(id)->finished(); }));
    EXPECT_TRUE(jobs->cancel(id)) << "forgotten";
  }
  Terms late = of("a");
  late.deadline = std::chrono::steady_clock::now();
  for (std::uint64_t seed = 100; seed < 110; ++seed)
    jobs->start(fracture_request("mesh", seed), late, {}, [](const JobView&) {});
  EXPECT_TRUE(eventually(kPatience, "all to be finished", [&] { return jobs->figures().unfinished == 0; }));
  gate.open = true;
  started("a", 1);
}

/// Starts five jobs of a client and waits until they are done. Returns their addresses.
std::vector<std::string> finished_jobs(TestServer& server, const std::string& client) {
  std::vector<std::string> jobs;
  for (int seed = 0; seed < 5; ++seed) {
    jobs.push_back(server.post("/fracture?seed=" + std::to_string(seed), "mesh", kAsync + by(client))
                       .header("location"));
    wait_for_state(server, jobs.back(), "done", by(client));
  }
  return jobs;
}

/// A thousand jobs with known answers cost next to nothing. The jobs of others stay, even after a restart.
TEST(DurableHolders, FinishedJobsOfOthersOutliveAFloodOfKnownAnswers) {
  const TemporaryFolder folder;
  TestServerOptions options = durable(folder);
  options.jobs.max_jobs = 20;
  options.server.tokens = *tenants::TokenFile::parse(tenant_file({tenant("ana"), tenant("bob")}));
  std::vector<std::string> anas;
  {
    TestServer server(options);
    anas = finished_jobs(server, "ana");
    for (int k = 0; k < 100; ++k)
      ASSERT_EQ(server.post("/fracture?seed=77", "mesh", kAsync + by("bob")).status, 202) << k;
    for (const std::string& job : anas) EXPECT_EQ(server.get(job, by("ana")).status, 200) << job;
    EXPECT_EQ(server.api.jobs().figures().jobs, 20u);
  }
  TestServer server(options);
  for (int k = 0; k < 30; ++k)
    ASSERT_EQ(server.post("/fracture?seed=77", "mesh", kAsync + by("bob")).status, 202) << k;
  for (const std::string& job : anas)
    EXPECT_EQ(server.get(server.get(job, by("ana")).json().at("result"), by("ana")).status, 200) << job;
}

/// Of 20 jobs, ten unfinished ones are for clients with more than one, and a client that is alone gets eight.
TEST(DurableHolders, AfterARestartAJobWithoutATokenCountsForItsAddress) {
  const TemporaryFolder folder;
  Gate gate;
  TestServerOptions options = durable(folder);
  options.control = std::make_shared<FakeControl>();
  options.control->during_cut = gate.hook();
  options.jobs.max_jobs = 20;
  int seed = 0;
  const auto start = [&](TestServer& server, const std::string& from) {
    return ask(server.port(), "POST", "/fracture?seed=" + std::to_string(++seed), kAsync, "mesh", from)
        .status;
  };
  {
    TestServer server(options);
    for (int k = 0; k < 4; ++k) ASSERT_EQ(start(server, "127.0.0.2"), 202) << k;
  }
  TestServer server(options);
  EXPECT_EQ(server.api.jobs().figures().unfinished, 4u);
  for (int k = 4; k < 8; ++k) EXPECT_EQ(start(server, "127.0.0.2"), 202) << k;
  EXPECT_EQ(start(server, "127.0.0.2"), 429) << "it has eight";
  EXPECT_EQ(start(server, "127.0.0.3"), 202);
}

/// The disk cache evicts the least recently used answers, but not results of jobs that can still be fetched.
TEST(DurableHolders, ResultsOfFinishedJobsOutliveAFloodOfNewAnswers) {
  const TemporaryFolder folder;
  TestServerOptions options = durable(folder);
  options.control = std::make_shared<FakeControl>();
  options.control->glb_padding = 10'000;
  options.service.tiers.disk_bytes = 300'000;
  options.server.tokens = *tenants::TokenFile::parse(tenant_file({tenant("ana"), tenant("bob")}));
  const auto flood = [](TestServer& server, int first) {
    for (int seed = first; seed < first + 60; ++seed)
      ASSERT_EQ(server
                    .post("/fracture?seed=" + std::to_string(seed), "mesh",
                          "Content-Type: model/gltf-binary\r\n" + by("bob"))
                    .status,
                200);
    server.service.tiers().flush();
  };
  std::vector<std::string> anas;
  {
    TestServer server(options);
    anas = finished_jobs(server, "ana");
    server.api.flush_jobs();
    EXPECT_GE(server.api.jobs().figures().pinned_bytes, 50'000u);
    flood(server, 100);
    EXPECT_GE(server.service.figures().tiers.disk->evictions, 30u);
    // Jobs of bob also pin their results, but the one with the most loses pins first.
    for (int seed = 200; seed < 220; ++seed)
      wait_for_state(server,
                     server.post("/fracture?seed=" + std::to_string(seed), "mesh", kAsync + by("bob"))
                         .header("location"),
                     "done", by("bob"));
    server.api.flush_jobs();
    EXPECT_LE(server.api.jobs().figures().pinned_bytes, 150'000u);
    EXPECT_GE(server.api.jobs().figures().pinned_bytes, 120'000u);
    flood(server, 300);
  }
  TestServer server(options);
  flood(server, 400);
  for (const std::string& job : anas)
    EXPECT_EQ(server.get(server.get(job, by("ana")).json().at("result"), by("ana")).status, 200) << job;
  const std::uint64_t pinned = server.api.jobs().figures().pinned_bytes;
  EXPECT_LE(pinned, 150'000u);
  for (const std::string& job : anas)
    EXPECT_EQ(ask(server.port(), "DELETE", job, by("ana")).status, 204) << job;
  EXPECT_LE(server.api.jobs().figures().pinned_bytes + 50'000, pinned) << "forgotten jobs have no pins";
}

}  // namespace
}  // namespace fracture::test
