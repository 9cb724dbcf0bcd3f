// How a server's memory is divided: given settings are kept, the others are made to fit, and settings that
// cannot fit are refused.
#include "server/cli/memory_plan.hpp"

#include <gmock/gmock.h>

#include <set>
#include <string>

#include "server/cli/serve_settings.hpp"

namespace fracture::cli {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::uint64_t kMiB = 1u << 20, kGiB = 1u << 30;

double resident(const ServeOptions& options) {
  double sum = 0;
  for (const MemoryShare& share : memory_shares(options)) sum += static_cast<double>(share.bytes);
  return static_cast<double>(base_memory(options)) + kResidentPerByte * sum;
}

ServeOptions small_server() {
  ServeOptions options;
  options.threads = 2;
  options.import_workers = 2;
  return options;
}

TEST(MemoryPlan, ALargeMachineKeepsTheDefaults) {
  ServeOptions options = small_server();
  const ServeOptions defaults = options;
  EXPECT_THAT(plan_memory(options, {}, 64 * kGiB), IsEmpty());
  EXPECT_EQ(options.memory, 64 * kGiB);
  EXPECT_EQ(options.dispatcher.max_working_bytes, defaults.dispatcher.max_working_bytes);
  EXPECT_EQ(options.store.quota_bytes, defaults.store.quota_bytes);
  EXPECT_EQ(options.limits.max_body, defaults.limits.max_body);
}

TEST(MemoryPlan, EverythingFitsIntoWhateverThereIs) {
  for (const std::uint64_t memory :
       {240 * kMiB, 256 * kMiB, 320 * kMiB, 512 * kMiB, 1 * kGiB, 2 * kGiB, 4 * kGiB}) {
    ServeOptions options = small_server();
    EXPECT_THAT(plan_memory(options, {}, memory), IsEmpty()) << memory / kMiB;
    EXPECT_LE(resident(options), static_cast<double>(memory)) << memory / kMiB;
    EXPECT_GT(resident(options), 0.99 * static_cast<double>(memory)) << "nothing is left over";
    EXPECT_LE(options.limits.max_body, options.limits.max_bodies);
    EXPECT_LE(options.service.import_limits.max_decoded_bytes, options.limits.max_bodies);
    EXPECT_LE(2 * options.import_memory, options.dispatcher.max_working_bytes)
        << "import workers are within it";
    EXPECT_GE(options.dispatcher.max_working_bytes, 64 * kMiB);
    EXPECT_GE(options.limits.max_connections, options.limits.max_connections_per_address);
    // A control group also charges the kernel's buffers for connections. Small answers are the server's own.
    EXPECT_LE(options.limits.max_connections * (http::kConnectionBytes - http::kSmallAnswer), memory / 16)
        << memory / kMiB;
    EXPECT_THAT(inconsistencies(options), IsEmpty());
  }
}

TEST(MemoryPlan, WhatIsGivenIsKeptAndTheOthersMakeRoom) {
  ServeOptions options = small_server();
  options.store.quota_bytes = 200 * kMiB;
  options.limits.max_body = 32 * kMiB;
  EXPECT_THAT(plan_memory(options, {"mesh-store", "max-body"}, 768 * kMiB), IsEmpty());
  EXPECT_EQ(options.store.quota_bytes, 200 * kMiB);
  EXPECT_EQ(options.limits.max_body, 32 * kMiB);
  EXPECT_GE(options.limits.max_bodies, 32 * kMiB);
  EXPECT_LE(resident(options), 768.0 * kMiB);
}

TEST(MemoryPlan, WhatCannotFitIsRefusedWithTheSum) {
  ServeOptions options = small_server();
  options.store.quota_bytes = 1 * kGiB;
  const std::uint64_t before = options.dispatcher.max_working_bytes;
  EXPECT_THAT(plan_memory(options, {"mesh-store"}, 512 * kMiB),
              ElementsAre(AllOf(HasSubstr("120 MiB at rest"), HasSubstr("mesh-store 1024 MiB"),
                                HasSubstr("max-working at least 64 MiB"), HasSubstr("512 MiB"),
                                HasSubstr("--memory"))));
  EXPECT_EQ(options.dispatcher.max_working_bytes, before) << "nothing is changed";
  EXPECT_THAT(plan_memory(options, {}, 100 * kMiB), testing::SizeIs(1)) << "no server at all";
}

TEST(MemoryPlan, TheLeastThatItNamesWorksAndAMebibyteLessDoesNot) {
  for (const bool tier : {false, true})
    for (const std::uint64_t pending : {64 * kMiB, 4 * kMiB})
      for (const std::set<std::string>& given : {std::set<std::string>(), {"mesh-store"}}) {
        const auto plan = [&](std::uint64_t memory) {
          ServeOptions options = small_server();
          if (tier) options.service.tiers.folder = "a folder";
          options.service.tiers.max_pending_bytes = pending;
          return plan_memory(options, given, memory);
        };
        const std::vector<std::string> refused = plan(100 * kMiB);
        ASSERT_THAT(refused, testing::SizeIs(1));
        const std::string words = "the smallest value that works is ";
        const std::size_t at = refused[0].find(words);
        ASSERT_NE(at, std::string::npos) << refused[0];
        const std::uint64_t least = std::stoull(refused[0].substr(at + words.size()));
        EXPECT_THAT(plan(least * kMiB), IsEmpty());
        EXPECT_THAT(plan((least - 1) * kMiB), testing::SizeIs(1)) << least;
      }
}

TEST(MemoryPlan, ASettingIsGivenByFlagOrFile) {
  ServeOptions options;
  const std::vector<Setting> table = serve_settings(options);
  EXPECT_THAT(configure(options, table,
                        {{"memory", {"1GiB", "--memory"}},
                         {"threads", {"1", ""}},
                         {"import-workers", {"1", ""}},
                         {"mesh-cache", {"100MiB", "--mesh-cache"}}},
                        ""),
              IsEmpty());
  EXPECT_EQ(options.memory, 1 * kGiB);
  EXPECT_EQ(options.service.mesh_cache_bytes, 100 * kMiB);
  EXPECT_LT(options.store.quota_bytes, 1 * kGiB);
  EXPECT_LE(resident(options), 1.0 * kGiB);
}

}  // namespace
}  // namespace fracture::cli
