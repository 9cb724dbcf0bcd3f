// Three servers, a Redis and HAProxy as docker/compose.yaml arranges them. Tests what clients see while parts
// of it are killed, restarted or replaced. No step waits for a fixed time: every step waits until its event
// has happened, and fails if that takes longer than kPatience.
#include <gtest/gtest.h>

#include <set>

#include "tests/docker/farm.hpp"
#include "tests/docker/load.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::test {
namespace {

const bool kFull = full_tests();
constexpr int kClients = 3, kMeshes = 24, kSeeds = 4;

struct Topology : testing::Test {
  void SetUp() override {
    if (const std::string missing = Farm::missing(); !missing.empty()) GTEST_SKIP() << missing;
    // Stopping a server waits until HAProxy has noticed, however long that takes. A second signal then ends
    // the delay.
    farm = std::make_unique<Farm>("3600");
  }
  std::unique_ptr<Farm> farm;
};

void expect_no_failure(const Load& load, const char* when) {
  EXPECT_EQ(load.failed, 0) << when << ": " << load.first_failure();
}

TEST_F(Topology, AServerThatGoesTakesItsShareOfTheMeshesAndNoOthers) {
  constexpr int kKeys = 600;
  std::vector<std::string> paths;
  for (int k = 0; k < kKeys; ++k) paths.push_back("/meshes/sha256:" + sha256(std::to_string(k)).hex());
  const std::vector<std::string> before = farm->servers_of(paths);
  ASSERT_EQ(std::set(before.begin(), before.end()),
            (std::set<std::string>{"fracture1", "fracture2", "fracture3"}));
  for (int i = 0; i < kServers; ++i) {
    farm->kill(i);
    farm->wait_until(i, "DOWN");
    const std::vector<std::string> without = farm->servers_of(paths);
    int moved = 0;
    for (std::size_t k = 0; k < paths.size(); ++k) {
      EXPECT_NE(without[k], "fracture" + std::to_string(i + 1));
      if (without[k] == before[k]) continue;
      ++moved;
      EXPECT_EQ(before[k], "fracture" + std::to_string(i + 1)) << "moved, although its server is there";
    }
    std::printf("without fracture%d: %d of %d keys move\n", i + 1, moved, kKeys);
    EXPECT_LE(moved, kKeys * (1.0 / 3 + 0.05));
    farm->start(i);
    farm->wait_until(i, "UP");
  }
  EXPECT_EQ(farm->servers_of(paths), before) << "all are back";
}

// A path may name a mesh in several ways, but the first 16 digits always decide.
TEST_F(Topology, MeshResultsAndJobsOfOneMeshGoToOneServer) {
  for (int k = 0; k < 20; ++k) {
    const std::string digest = sha256("mesh " + std::to_string(k)).hex(), start = digest.substr(0, 16);
    std::string upper = digest;
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    const std::vector<std::string> servers = farm->servers_of(
        {"/meshes/sha256:" + digest, "/meshes/sha256%3A" + digest, "/meshes/sha256:" + upper,
         "/fractures/sha256:" + start + sha256("result").hex().substr(16),
         "/jobs/" + start + "0123456789abcdef", "/jobs/" + start + "0123456789abcdef/events"});
    EXPECT_EQ(std::set(servers.begin(), servers.end()).size(), 1u) << digest;
  }
}

TEST_F(Topology, AServerKilledUnderLoadFailsNoRequestAndIsWarmAgain) {
  for (int round = 0; round < (kFull ? 6 : 1); ++round) {
    const int victim = round % kServers;
    Load load(farm->port, kClients, kMeshes, kSeeds);
    load.wait_for(2 * kMeshes * kSeeds);
    farm->kill(victim);
    load.wait_for(kMeshes * kSeeds);
    farm->wait_until(victim, "DOWN");
    load.wait_for(kMeshes * kSeeds);
    farm->start(victim);
    farm->wait_until(victim, "UP");
    expect_no_failure(load, "kill and restart");
    // Repeats until all answers of a whole round are from caches, as before.
    int hits = 0, rounds = 0;
    EXPECT_TRUE(eventually(kPatience, "answers from caches alone", [&] {
      const int answered = load.answered, from_caches = load.from_caches;
      load.wait_for(kMeshes * kSeeds);
      hits = 100 * (load.from_caches - from_caches) / std::max(load.answered - answered, 1);
      ++rounds;
      return hits >= 99 || load.failed != 0;
    }));
    load.stop();
    expect_no_failure(load, "warm again");
    std::printf(
        "fracture%d killed and restarted: %d answers, %d failed, %d meshes put; after %d rounds %d %% hits\n",
        victim + 1, load.answered.load(), load.failed.load(), load.puts.load(), rounds, hits);
  }
}

// Results that the killed server had computed are not computed again: the remaining servers take them from
// Redis. If they do compute one, a counted failure to reach Redis must account for it. Redis gets 50 ms, and
// this machine may be busy.
TEST_F(Topology, TheSharedTierSavesRecomputation) {
  std::vector<StoredMesh> meshes;
  for (int m = 0; m < kMeshes; ++m) meshes.emplace_back(1000 + m);
  GameClient client(farm->port);
  const auto all = [&] {
    for (const StoredMesh& mesh : meshes)
      for (int seed = 0; seed < kSeeds; ++seed) EXPECT_EQ(client.fracture(mesh, seed).status, 200);
  };
  const auto troubles = [&] {
    return farm->sum("fracture_cache_failures_total", "redis") +
           farm->sum("fracture_cache_skipped_total", "redis") + farm->sum("fracture_results_unwritten_total");
  };
  constexpr int kResults = kMeshes * kSeeds;
  all();
  EXPECT_EQ(farm->sum("fracture_results_computed_total"), kResults);
  ASSERT_TRUE(eventually(kPatience, "all results in Redis, which are written in the background",
                         [&] { return farm->redis.entries().value_or(0) + troubles() >= kResults; }));
  const int unwritten = kResults - *farm->redis.entries();

  farm->kill(0);
  farm->wait_until(0, "DOWN");
  const double computed = farm->sum("fracture_results_computed_total"), trouble = troubles(),
               hits = farm->sum("fracture_cache_lookups_total", R"(cache="redis",outcome="hit")");
  const int lost = kResults - static_cast<int>(computed);  // only in the killed server's memory
  EXPECT_GT(lost, 0);
  all();
  const double again = farm->sum("fracture_results_computed_total") - computed,
               shared = farm->sum("fracture_cache_lookups_total", R"(cache="redis",outcome="hit")") - hits;
  std::printf("of %d results %d were the killed server's: %g from Redis, %g computed again\n", kResults, lost,
              shared, again);
  EXPECT_EQ(shared + again, lost);
  EXPECT_LE(again, unwritten + troubles() - trouble);
}

TEST_F(Topology, WithoutRedisServiceContinues) {
  Load load(farm->port, kClients, kMeshes, kSeeds);
  load.wait_for(kMeshes * kSeeds);
  farm->redis.kill();
  Load fresh(farm->port, kClients, kMeshes, 1'000'000);  // hardly any of these requests is in a cache
  load.wait_for(kMeshes * kSeeds);
  fresh.wait_for(kMeshes * kSeeds);
  EXPECT_GT(farm->sum("fracture_cache_failures_total", "redis"), 0);
  farm->redis.start();
  EXPECT_TRUE(eventually(kPatience, "the servers to find Redis again",
                         [&] { return farm->redis.entries().value_or(0) != 0 || fresh.failed != 0; }));
  load.stop();
  fresh.stop();
  expect_no_failure(load, "known results");
  expect_no_failure(fresh, "new results");
}

// HAProxy closes its own side if its client does (option abortonclose).
TEST_F(Topology, AClientThatLeavesStopsItsComputation) {
  const StoredMesh mesh(1);
  GameClient game(farm->port);
  EXPECT_EQ(game.fracture(mesh, 1).status, 200);
  const std::string parameters = R"({"sites": 20000, "lloyd": 50})";  // a minute for one thread
  for (int k = 1; k <= 2; ++k) {
    RawClient client(farm->port);
    client.send("POST " + mesh.path + "/fracture HTTP/1.1\r\nHost: localhost\r\nPriority: u=3\r\n" +
                "Content-Type: application/json\r\nContent-Length: " + std::to_string(parameters.size()) +
                "\r\n\r\n" + parameters);
    require_eventually(kPatience, "the computation", [&] { return farm->sum("fracture_jobs_running") == 1; });
    if (k == 1)
      client.half_close();
    else
      client.reset();
    EXPECT_TRUE(eventually(kPatience, "the computation to stop", [&] {
      return farm->sum("fracture_flights") == 0 && farm->sum("fracture_jobs_running") == 0;
    }));
    EXPECT_TRUE(eventually(kPatience, "the request to be counted",
                           [&] { return farm->sum("fracture_requests_total", "status=\"499\"") == k; }));
  }
  EXPECT_EQ(farm->sum("fracture_work_abandoned_total"), 2);
  EXPECT_EQ(game.fracture(mesh, 2).status, 200);
}

TEST_F(Topology, ARollingRestartUnderLoadFailsNoRequest) {
  if (kFull) farm = std::make_unique<Farm>("5");  // as docker/compose.yaml has it
  Load load(farm->port, kClients, kMeshes, kSeeds);
  for (int round = 0; round < (kFull ? 3 : 1); ++round)
    for (int i = 0; i < kServers; ++i) {
      load.wait_for(kMeshes);
      farm->server(i).signal(SIGTERM);
      farm->wait_until(i, "DOWN");
      load.wait_for(kMeshes);
      if (!kFull) farm->server(i).signal(SIGTERM);
      EXPECT_EQ(exit_code(farm->server(i), "fracture" + std::to_string(i + 1)), 0);
      load.wait_for(kMeshes);
      farm->kill(i);
      farm->start(i);
      farm->wait_until(i, "UP");
    }
  load.wait_for(kMeshes * kSeeds);
  load.stop();
  expect_no_failure(load, "rolling restart");
  std::printf("rolling restart: %d answers, %d failed, %d meshes put\n", load.answered.load(),
              load.failed.load(), load.puts.load());
}

}  // namespace
}  // namespace fracture::test
