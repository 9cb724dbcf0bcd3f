// Results that wait to be written to a slow tier: whose turn it is, and whose results are dropped if too many wait.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/service/dispatcher.hpp"
#include "server/service/result_tiers.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/fracture_request.hpp"
#include "tests/server/support/slow_redis.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

using Keys = std::vector<std::string>;

/// A Redis in which the first write does not end until the test opens it.
struct TierWrites : testing::Test {
  static constexpr std::size_t kMiB = 1u << 20;
  TemporaryFolder folder;
  SlowRedis redis{folder / "redis.sock"};
  TiersConfig config;

  void SetUp() override {
    config.redis.address = folder / "redis.sock";
    config.redis.connect_timeout = config.redis.operation_timeout = kPatience;
    config.max_pending_bytes = 10 * kMiB + kMiB / 2;
  }
  /// Returns a result whose key has 64 digits and ends with `name`, which must consist of hex digits.
  static std::shared_ptr<const FractureResult> result(const std::string& name, std::size_t bytes = kMiB) {
    auto made = std::make_shared<FractureResult>();
    made->key = std::string(64 - name.size(), '0') + name;
    made->mesh_digest = "sha256:" + std::string(64, '0');
    made->parameters = "{}";
    made->file.assign(bytes, 'x');
    return made;
  }
  /// Stores results of one client, which is the first letter of their names.
  static void store(ResultTiers& tiers, const Keys& names, std::size_t bytes = kMiB) {
    for (const std::string& name : names) tiers.store(result(name, bytes), name.substr(0, 1));
  }
  /// Stores a first result, and waits until it is being written.
  void begin(ResultTiers& tiers, const std::string& name) {
    store(tiers, {name});
    EXPECT_TRUE(eventually(kPatience, "the first write", [&] { return redis.written().size() == 1; }));
  }
  /// Lets everything be written. Returns the names in the order in which they were written.
  Keys end(ResultTiers& tiers) {
    redis.open();
    tiers.flush();
    Keys names;
    for (const std::string& key : redis.written()) names.push_back(key.substr(key.size() - 2));
    return names;
  }
  struct Made {
    std::string key;
    CacheOutcome redis;
  };
  /// Asks for an answer on behalf of a client.
  static Made answer_for(Dispatcher& dispatcher, const std::string& client, std::uint64_t seed) {
    Terms terms;
    terms.payer.flow.name = client;
    Made made{};
    const auto refused =
        dispatcher.fracture(fracture_request("mesh", seed), terms, [&made](const auto& answer) {
          if (answer)
            made = {answer->result->key, answer->redis_cache};
          else
            ADD_FAILURE() << answer.error().detail;
        });
    EXPECT_FALSE(refused);
    dispatcher.wait_idle();
    return made;
  }
};

TEST_F(TierWrites, TheFloodOfOneDelaysAnotherByOneWriteOnly) {
  ResultTiers tiers(config);
  begin(tiers, "a0");
  store(tiers, {"a1", "a2", "a3", "a4"});
  store(tiers, {"b0"});
  EXPECT_EQ(end(tiers), (Keys{"a0", "b0", "a1", "a2", "a3", "a4"}));
  EXPECT_EQ(tiers.figures().dropped, 0u);
}

TEST_F(TierWrites, TheClientThatHoldsTheMostLosesItsNewest) {
  ResultTiers tiers(config);
  begin(tiers, "a0");
  const auto dropped = [&] { return tiers.figures().dropped; };
  store(tiers, {"a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8", "a9", "aa"});
  EXPECT_EQ(dropped(), 0u) << "ten wait, and the first one is being written";
  store(tiers, {"ab"});
  EXPECT_EQ(dropped(), 1u) << "no answer of another client waits, so the new one is dropped";
  store(tiers, {"b0", "b1"});
  EXPECT_EQ(dropped(), 3u) << "8 of one client and 2 of the other";
  store(tiers, {"c0"}, 5 * kMiB);
  EXPECT_EQ(dropped(), 8u) << "3, 2, and one of 5 MiB";
  store(tiers, {"c1"}, 5 * kMiB);
  EXPECT_EQ(dropped(), 9u) << "the third would hold the most";
  store(tiers, {"b2"});
  EXPECT_EQ(dropped(), 10u) << "the second would hold as much as the first, and the third has only one";
  Keys written = end(tiers);
  std::sort(written.begin(), written.end());
  EXPECT_EQ(written, (Keys{"a0", "a1", "a2", "a3", "b0", "b1", "c0"}));
}

TEST_F(TierWrites, TheFirstResultOfAClientIsKeptWhateverOthersHold) {
  ResultTiers tiers(config);
  begin(tiers, "a0");
  store(tiers, {"a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8", "a9", "aa"});
  store(tiers, {"b0"}, 9 * kMiB);
  EXPECT_EQ(tiers.figures().dropped, 9u) << "all but the first one";
  store(tiers, {"c0"}, 9 * kMiB);
  EXPECT_EQ(tiers.figures().dropped, 10u) << "the others have one each";
  store(tiers, {"d0"}, 11 * kMiB);
  EXPECT_EQ(tiers.figures().dropped, 11u) << "larger than the limit";
  EXPECT_EQ(end(tiers), (Keys{"a0", "b0", "a1"}));
}

TEST_F(TierWrites, AJobDoesNotWaitForWhatOthersWrite) {
  config.folder = folder / "cache";
  ResultTiers tiers(config);
  begin(tiers, "a0");
  store(tiers, {"a1"});
  store(tiers, {"b0"});
  EXPECT_TRUE(tiers.keep_on_disk(result("b0"))) << "it waits for Redis";
  EXPECT_TRUE(tiers.keep_on_disk(result("a0"))) << "it is being written to Redis";
  EXPECT_EQ(redis.written().size(), 1u);
  EXPECT_EQ(end(tiers), (Keys{"a0", "b0", "a1"}));
  EXPECT_EQ(tiers.figures().disk->writes, 3u) << "each once";
}

TEST_F(TierWrites, ARequestsAnswerIsWrittenAtTheTurnOfItsClient) {
  ServiceConfig with;
  with.tiers = config;
  FractureService service(with, std::make_unique<FakeEngine>(std::make_shared<FakeControl>()));
  WorkerPool pool(1, 100);
  Dispatcher dispatcher(service, pool);
  std::mutex mutex;
  std::vector<std::pair<std::string, std::string>> made;  // client and key
  const auto ask = [&](const std::string& client, std::uint64_t seed) {
    Terms terms;
    terms.payer.flow.name = client;
    const std::size_t before = made.size();
    const auto refused =
        dispatcher.fracture(fracture_request("mesh", seed), terms, [&, client](const auto& answer) {
          const std::lock_guard lock(mutex);
          made.emplace_back(client, answer ? answer->result->key : answer.error().detail);
        });
    EXPECT_FALSE(refused);
    dispatcher.wait_idle();
    EXPECT_EQ(made.size(), before + 1);
  };
  ask("a", 1);
  EXPECT_TRUE(eventually(kPatience, "the first write", [&] { return redis.written().size() == 1; }));
  ask("a", 2);
  ask("a", 3);
  ask("b", 4);
  redis.open();
  service.tiers().flush();
  EXPECT_EQ(redis.written(), (Keys{made[0].second, made[3].second, made[1].second, made[2].second}));
}

/// Ten answers of 1 MiB may wait for the disk. A reader with more loses its newest for another reader's first.
TEST_F(TierWrites, AnAnswerFromRedisIsWrittenToTheDiskAtTheTurnOfItsReader) {
  const auto control = std::make_shared<FakeControl>();
  control->glb_padding = kMiB;
  ServiceConfig with;
  with.tiers = config;
  redis.open();
  {
    FractureService service(with, std::make_unique<FakeEngine>(control));
    WorkerPool pool(1, 100);
    Dispatcher dispatcher(service, pool);
    for (std::uint64_t seed = 1; seed <= 13; ++seed) {
      answer_for(dispatcher, "name of another server", seed);
      service.tiers().flush();
    }
  }
  ASSERT_EQ(redis.written().size(), 13u);
  redis.close();
  with.tiers.folder = folder / "cache";
  FractureService service(with, std::make_unique<FakeEngine>(control));
  WorkerPool pool(1, 100);
  Dispatcher dispatcher(service, pool);
  answer_for(dispatcher, "name eve", 14);  // computed; while Redis does not answer, nothing else is written
  EXPECT_TRUE(eventually(kPatience, "the first write", [&] { return redis.written().size() == 14; }));
  std::vector<std::string> anas;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Made made = answer_for(dispatcher, "name ana", seed);
    EXPECT_EQ(made.redis, CacheOutcome::kHit) << seed;
    anas.push_back(made.key);
  }
  EXPECT_EQ(service.tiers().figures().dropped, 2u) << "her last two, because ten wait";
  const Made bobs = answer_for(dispatcher, "name bob", 13);
  EXPECT_EQ(bobs.redis, CacheOutcome::kHit);
  EXPECT_EQ(service.tiers().figures().dropped, 3u);
  redis.open();
  service.tiers().flush();
  EXPECT_TRUE(service.tiers().on_disk(bobs.key));
  for (std::size_t k = 0; k < anas.size(); ++k) EXPECT_EQ(service.tiers().on_disk(anas[k]), k < 9) << k;
  EXPECT_EQ(redis.written().size(), 14u) << "answers from Redis are not written to it again";
  EXPECT_EQ(control->cuts, 14);
}

}  // namespace
}  // namespace fracture::test
