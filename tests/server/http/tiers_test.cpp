// The cache tiers of a whole server: what is found after a restart, and what a broken tier does.
#include <gtest/gtest.h>

#include <fstream>
#include <optional>

#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/test_server.hpp"

namespace fracture::test {
namespace {

struct Tiers : testing::Test {
  TemporaryFolder folder;
  TestServerOptions options;
  void SetUp() override { options.service.tiers.folder = folder.path + "/cache"; }
};

TEST_F(Tiers, AResultSurvivesARestartOnTheDisk) {
  Reply made;
  {
    TestServer server(options);
    made = server.post("/fracture?sites=5");
    server.service.tiers().flush();
  }
  TestServer server(options);
  const Reply got = server.get(made.header("content-location"));
  ASSERT_EQ(got.status, 200) << got.body;
  EXPECT_EQ(got.body, made.body);
  EXPECT_EQ(got.header("etag"), made.header("etag"));
  EXPECT_EQ(got.header("repr-digest"), made.header("repr-digest"));
  EXPECT_EQ(got.header("cache-status"), "disk; hit, result; fwd=miss; stored");
  EXPECT_EQ(server.get(made.header("content-location")).header("cache-status"), "result; hit")
      << "now in memory";
}

TEST_F(Tiers, AskedForAgainItIsReadAndNotComputed) {
  {
    TestServer server(options);
    server.post("/fracture?sites=5");
    server.service.tiers().flush();
  }
  TestServer server(options);
  const Reply again = server.post("/fracture?sites=5");
  EXPECT_EQ(again.status, 200);
  EXPECT_EQ(server.control->imports, 0);
  EXPECT_EQ(again.header("cache-status"), "disk; hit, result; fwd=miss; stored");
}

TEST_F(Tiers, AnAnswerFromTheDiskCanBeNamedByAFurtherRequest) {
  Reply made;
  {
    TestServer server(options);
    made = server.post("/fracture?sites=5");
    server.service.tiers().flush();
  }
  const std::string location = made.header("content-location");
  TestServer server(options);
  EXPECT_EQ(server.post("/fracture?density=7&of=" + location).problem(), "no-such-answer") << "not read yet";
  ASSERT_EQ(server.get(location).status, 200);
  const Reply further = server.post("/fracture?density=7&of=" + location);
  ASSERT_EQ(further.status, 200) << further.body;
  EXPECT_EQ(further.body, server.post("/fracture?density=7&sites=5").body);
}

// The earlier version also stored the position of the parameters in the file, after that of the report,
// instead of the parameters themselves.
TEST_F(Tiers, AnEntryOfAnEarlierVersionIsRead) {
  Reply made;
  {
    TestServer server(options);
    made = server.post("/fracture?sites=5");
    server.service.tiers().flush();
  }
  const std::string location = made.header("content-location");
  const std::string key = location.substr(std::string("/fractures/sha256:").size());
  {
    std::optional<DiskCache> cache(std::in_place, options.service.tiers.folder, 1 << 30);
    const auto stored = cache->find(key);
    ASSERT_TRUE(stored);
    const std::vector<std::uint8_t> payload(stored->entry.payload.begin(), stored->entry.payload.end());
    const TextRange figures = figures_in(payload, OutputFormat::kGlb).value();
    const std::string text(payload.begin(), payload.end()), name = "\"parameters\":";
    const std::size_t begin = text.find(name, figures.at) + name.size();  // the last in the fake's report
    std::string metadata(stored->entry.metadata);
    const std::size_t ranges = metadata.find('\n', metadata.find('\n') + 1) + 1;
    const std::size_t digests = metadata.size() - 2 * sizeof(Digest::bytes);
    metadata.replace(ranges, digests - ranges,
                     std::to_string(figures.at) + " " + std::to_string(figures.size) + " " +
                         std::to_string(begin) + " " + std::to_string(figures.at + figures.size - 1 - begin) +
                         "\n");
    std::filesystem::remove(entries_in(options.service.tiers.folder).at(0));
    cache.reset();  // A folder has only one owner.
    DiskCache(options.service.tiers.folder, 1 << 30).insert({key, metadata, payload});
  }
  TestServer server(options);
  const Reply got = server.get(location);
  ASSERT_EQ(got.status, 200) << got.body;
  EXPECT_EQ(got.body, made.body);
  EXPECT_EQ(server.get(location, "Accept: application/json\r\n").json().at("parameters").at("sites"), 5);
  EXPECT_EQ(server.post("/fracture?density=7&of=" + location).status, 200);
}

/// An entry whose checksum and digests are right but whose parameters are forged. Anybody who can write to
/// the folder, or to a Redis without keys, can make one.
TEST_F(Tiers, AForgedEntryIsNeitherGivenNorNamedAndIsReplaced) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  std::string objects;
  for (int k = 0; k < 200'000; ++k) objects += "{\"a\":";
  objects += "1" + std::string(200'000, '}');
  int seed = 0;
  for (const std::string& forged :
       {"{\"sites\":5,\"x\":" + deep + "}", "{\"sites\":5,\"x\":" + objects + "}", std::string("[]"),
        std::string("{"), std::string(R"({"sites":"x","local_point":5,"material":[]})"),
        std::string(R"({"local_point":{"a":1},"local_radius":"x"})"), std::string(R"({"sites":4000000000})"),
        std::string(R"({"stretch":1e999})")}) {
    Reply made;
    const std::string asked = "/fracture?seed=" + std::to_string(++seed);
    {
      TestServer server(options);
      made = server.post(asked);
      server.service.tiers().flush();
    }
    const std::string location = made.header("content-location"),
                      key = location.substr(std::string("/fractures/sha256:").size());
    {
      DiskCache cache(options.service.tiers.folder, 1 << 30);
      const auto stored = cache.find(key);
      ASSERT_TRUE(stored);
      const std::vector<std::uint8_t> payload(stored->entry.payload.begin(), stored->entry.payload.end());
      std::string metadata(stored->entry.metadata);
      std::size_t at = 0;
      for (int line = 0; line < 3; ++line) at = metadata.find('\n', at) + 1;
      metadata.replace(at, metadata.size() - 2 * sizeof(Digest::bytes) - 1 - at, forged);
      cache.refuse(key);
      ASSERT_TRUE(cache.insert({key, metadata, payload}));
    }
    TestServer server(options);
    EXPECT_EQ(server.get(location).status, 404) << forged.substr(0, 40);
    EXPECT_EQ(server.post("/fracture?density=7&of=" + location).problem(), "no-such-answer");
    EXPECT_EQ(server.service.figures().tiers.disk->quarantined, 1u);
    EXPECT_EQ(server.post(asked).body, made.body) << "computed";
    server.service.tiers().flush();
    EXPECT_EQ(server.control->cuts, 1);
    EXPECT_TRUE(server.service.tiers().on_disk(key)) << "and written in its place";
  }
}

TEST_F(Tiers, ADamagedEntryIsComputedAgain) {
  std::string good;
  {
    TestServer server(options);
    good = server.post("/fracture?sites=5").body;
    server.service.tiers().flush();
  }
  const auto files = entries_in(folder.path + "/cache");
  ASSERT_EQ(files.size(), 1u);
  std::fstream(files[0], std::ios::in | std::ios::out | std::ios::binary).seekp(200).put('!');
  TestServer server(options);
  const Reply again = server.post("/fracture?sites=5");
  EXPECT_EQ(again.body, good);
  EXPECT_EQ(server.control->cuts, 1);
  EXPECT_EQ(server.service.figures().tiers.disk->quarantined, 1u);
  server.service.tiers().flush();
  EXPECT_EQ(server.service.figures().tiers.disk->entries, 1u) << "and written again";
}

TEST_F(Tiers, AnAnswerIsNotBelievedForTheDigestBesideIt) {
  Reply made;
  {
    TestServer server(options);
    made = server.post("/fracture?sites=5");
    server.service.tiers().flush();
  }
  const std::string key = made.header("content-location").substr(std::string("/fractures/sha256:").size());
  // An attacker who can write to a tier changes the answer and every checksum.
  {
    DiskCache cache(options.service.tiers.folder, 1 << 30);
    const auto stored = cache.find(key);
    ASSERT_TRUE(stored);
    std::vector<std::uint8_t> payload(stored->entry.payload.begin(), stored->entry.payload.end());
    payload.back() ^= 1;
    const std::string metadata(stored->entry.metadata);
    std::filesystem::remove(entries_in(options.service.tiers.folder).at(0));
    DiskCache(folder.path + "/forged", 1 << 30).insert({key, metadata, payload});
    std::filesystem::rename(entries_in(folder.path + "/forged").at(0),
                            options.service.tiers.folder + "/" + key.substr(0, 2) + "/" + key);
  }
  TestServer server(options);
  EXPECT_EQ(server.get(made.header("content-location")).status, 404);
  EXPECT_EQ(server.post("/fracture?sites=5").body, made.body);
  EXPECT_EQ(server.control->cuts, 1) << "computed again";
}

TEST_F(Tiers, ATierThatCannotBeUsedIsSeenInTheMetrics) {
  const auto metric = [](TestServer& server, const std::string& tier) {
    const std::string text = ask(server.server.admin_port(), "GET", "/metrics").body;
    const std::string name = "fracture_cache_tier_up{cache=\"result\",tier=\"" + tier + "\"} ";
    const std::size_t at = text.find(name);
    return at == std::string::npos ? std::string("none") : text.substr(at + name.size(), 1);
  };
  {
    TestServer server(options);
    EXPECT_EQ(metric(server, "disk"), "1");
    EXPECT_EQ(metric(server, "redis"), "none");
  }
  std::ofstream(folder.path + "/file") << "x";
  options.service.tiers.folder = folder.path + "/file";
  options.service.tiers.redis.address = "127.0.0.1:1";  // Nobody listens there.
  TestServer server(options);
  EXPECT_EQ(metric(server, "disk"), "0");
  EXPECT_EQ(metric(server, "redis"), "1") << "not asked yet";
  for (int seed = 0; seed < 5; ++seed) server.post("/fracture?seed=" + std::to_string(seed));
  EXPECT_EQ(metric(server, "redis"), "0");
}

TEST_F(Tiers, WithoutAUsableFolderOrARedisRequestsAreAnsweredAllTheSame) {
  std::ofstream(folder.path + "/file") << "x";
  options.service.tiers.folder = folder.path + "/file";
  options.service.tiers.redis.address = "127.0.0.1:1";  // Nobody listens there.
  TestServer server(options);
  EXPECT_TRUE(server.service.tiers().disk_unusable());
  for (int seed = 0; seed < 10; ++seed)
    EXPECT_EQ(server.post("/fracture?seed=" + std::to_string(seed)).status, 200);
  EXPECT_EQ(server.control->cuts, 10);
  const auto redis = server.service.figures().tiers.redis;
  ASSERT_TRUE(redis);
  EXPECT_TRUE(redis->open);
  EXPECT_EQ(server.get("/fractures/sha256:" + std::string(64, '0')).problem(), "not-found");
}

TEST_F(Tiers, AFolderThatGoesAwayWhileServingIsNoError) {
  TestServer server(options);
  server.post("/fracture?seed=1");
  server.service.tiers().flush();
  std::filesystem::remove_all(options.service.tiers.folder);
  for (int seed = 2; seed < 6; ++seed)
    EXPECT_EQ(server.post("/fracture?seed=" + std::to_string(seed)).status, 200);
  server.service.tiers().flush();
  EXPECT_EQ(server.service.figures().tiers.disk->failures, 4u);
}

}  // namespace
}  // namespace fracture::test
