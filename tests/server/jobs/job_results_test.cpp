// The result of a done job is there until the job is deleted, or else the job says that it is lost.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/support/job_server.hpp"
#include "tests/server/support/tenant_file.hpp"

namespace fracture::test {
namespace {

const std::string kGlb = "Content-Type: model/gltf-binary\r\n";

/// Each answer has a little more than this many bytes.
constexpr std::size_t kPadding = 10'000;

std::string seeded(int seed) { return "/fracture?seed=" + std::to_string(seed); }

struct JobResults : testing::Test {
  TemporaryFolder folder;

  /// Options of a server on which ana may have that many bytes of answers.
  TestServerOptions options(bool on_disk, std::uint64_t cached_bytes) {
    TestServerOptions made = on_disk ? durable(folder) : TestServerOptions();
    made.control = std::make_shared<FakeControl>();
    made.control->glb_padding = kPadding;
    made.server.tokens = *tenants::TokenFile::parse(
        tenant_file({tenant("ana", {"read", "fracture", "bake"}, {{"cached_bytes", cached_bytes}}),
                     tenant("bob"), tenant("boss", {"read", "admin"})}));
    return made;
  }
  static std::string start(TestServer& server, int seed, const std::string& fields) {
    const Reply accepted = server.post(seeded(seed), "mesh", kAsync + fields);
    EXPECT_EQ(accepted.status, 202) << accepted.body;
    return accepted.header("location");
  }
  /// Returns the address of the job's result.
  static std::string result_of(TestServer& server, const std::string& job, const std::string& fields) {
    return wait_for_state(server, job, "done", fields).value("result", "none");
  }
};

TEST_F(JobResults, OneLargerThanCachedBytesIsThereForItsNameUntilTheJobIsDeleted) {
  for (const bool on_disk : {false, true}) {
    TestServer server(options(on_disk, kPadding / 2));
    const std::string job = start(server, 1, by("ana")), result = result_of(server, job, by("ana"));
    for (const char* method : {"GET", "HEAD"}) {
      EXPECT_EQ(ask(server.port(), method, result, by("ana")).status, 200) << on_disk;
      EXPECT_EQ(ask(server.port(), method, result, by("bob")).status, 404) << on_disk;
      EXPECT_EQ(ask(server.port(), method, result, by("boss")).status, 200) << on_disk;
    }
    const std::string hit = "/fracture?physics=none&of=" + result;
    EXPECT_EQ(server.post(hit, "mesh", kGlb + by("ana")).status, 200) << "it can also be named";
    EXPECT_EQ(server.post(hit, "mesh", kGlb + by("bob")).problem(), "no-such-answer");
    EXPECT_EQ(ask(server.port(), "DELETE", job, by("ana")).status, 204);
    const Reply gone = server.get(result, by("ana"));
    EXPECT_EQ(gone.status, 404) << on_disk;
    EXPECT_EQ(gone.problem(), "not-found") << "it was deleted, not lost";
  }
}

TEST_F(JobResults, OtherAnswersOfTheNameDoNotPushItOut) {
  TestServer server(options(true, 5 * kPadding / 2));
  const std::string job = start(server, 1, by("ana")), result = result_of(server, job, by("ana"));
  std::vector<std::string> others;
  for (int seed = 10; seed < 16; ++seed)
    others.push_back(server.post(seeded(seed), "mesh", kGlb + by("ana")).header("content-location"));
  EXPECT_EQ(server.get(result, by("ana")).status, 200);
  EXPECT_EQ(server.get(others.front(), by("ana")).status, 404) << "cached_bytes holds for other answers";
  EXPECT_EQ(server.get(others.back(), by("ana")).status, 200);
  EXPECT_EQ(server.get(job, by("ana")).json().value("state", ""), "done");
}

TEST_F(JobResults, AfterARestartItIsThereToo) {
  std::string job;
  {
    TestServer server(options(true, kPadding / 2));
    job = start(server, 1, by("ana"));
    wait_for_state(server, job, "done", by("ana"));
  }
  TestServer server(options(true, kPadding / 2));
  const std::string result = result_of(server, job, by("ana"));
  EXPECT_EQ(server.get(result, by("ana")).status, 200);
  EXPECT_EQ(server.get(result, by("bob")).status, 404);
  EXPECT_EQ(server.control->cuts, 0);
}

TEST_F(JobResults, WhenTheJobIsForgottenCachedBytesHoldsAgain) {
  TestServerOptions brief = options(false, kPadding / 2);
  brief.jobs.ttl = std::chrono::milliseconds(200);
  TestServer server(brief);
  const std::string result =
      server.post(seeded(1), "mesh", kGlb + by("bob")).header("content-location");  // the same answer
  start(server, 1, by("ana"));
  EXPECT_TRUE(eventually(kPatience, "the result to be hidden", [&] {
    return server.api.jobs().figures().expired == 0 ? server.get("/jobs", by("ana")).status == 0
                                                    : server.get(result, by("ana")).status == 404;
  }));
  EXPECT_EQ(server.get(result, by("bob")).status, 200);
}

TEST_F(JobResults, AJobWhoseResultCannotBeKeptSaysSo) {
  TestServerOptions narrow;
  narrow.service.result_cache_bytes = 0;
  narrow.jobs.max_result_bytes = 1;
  TestServer server(narrow);
  const std::string job = start(server, 1, "");
  const auto lost = wait_for_state(server, job, "failed");
  ASSERT_TRUE(lost.contains("error")) << lost.dump();
  EXPECT_EQ(lost.at("error").at("type"), "/problems/job-lost");
  EXPECT_NE(lost.at("error").at("detail").get<std::string>().find("--job-results"), std::string::npos);
  EXPECT_FALSE(lost.contains("result"));
  EXPECT_EQ(server.get("/jobs?state=failed").json().at("jobs").size(), 1u);
  const std::string result = server.post(seeded(1), "mesh", kGlb).header("content-location");
  const Reply gone = server.get(result);
  EXPECT_EQ(gone.status, 500) << gone.body;
  EXPECT_EQ(gone.problem(), "job-lost") << "not only that it is not found";
  const std::string other = server.post(seeded(2), "mesh", kGlb).header("content-location");
  EXPECT_EQ(server.get(other).problem(), "not-found") << "no job has promised it";
}

/// There is room for two results in memory, and no other cache.
TEST_F(JobResults, WhoHasMostLosesItsOldestAndOthersKeepTheirs) {
  TestServerOptions narrow = options(false, kPadding / 2);
  narrow.service.result_cache_bytes = 0;
  narrow.jobs.max_result_bytes = 5 * kPadding / 2;
  TestServer server(narrow);
  const std::string of_ana = start(server, 1, by("ana")), result = result_of(server, of_ana, by("ana"));
  std::vector<std::string> of_bob, results;
  for (int seed = 10; seed < 14; ++seed) {
    of_bob.push_back(start(server, seed, by("bob")));
    results.push_back(result_of(server, of_bob.back(), by("bob")));
  }
  EXPECT_EQ(server.get(result, by("ana")).status, 200);
  EXPECT_EQ(server.get(results.back(), by("bob")).status, 200);
  EXPECT_EQ(server.get(results.front(), by("bob")).problem(), "job-lost");
  EXPECT_EQ(server.get(results.front(), by("ana")).problem(), "not-found") << "a job of another name";
  EXPECT_EQ(server.get(of_bob.front(), by("bob")).json().at("error").at("type"), "/problems/job-lost");
}

/// Nothing stays in memory. Half of the disk tier has room for two results of jobs, and all of it for five.
TEST_F(JobResults, WhatTheDiskHasToGiveUpIsSaidByTheJob) {
  TestServerOptions narrow = options(true, kPadding / 2);
  narrow.service.result_cache_bytes = 0;
  narrow.service.tiers.disk_bytes = 6 * kPadding;
  narrow.jobs.max_result_bytes = 1;
  TestServer server(narrow);
  std::vector<std::string> jobs, results;
  for (int seed = 1; seed < 4; ++seed) {
    jobs.push_back(start(server, seed, by("ana")));
    results.push_back(result_of(server, jobs.back(), by("ana")));
    server.api.flush_jobs();
    EXPECT_EQ(server.get(results.back(), by("ana")).status, 200) << seed;
  }
  server.api.flush_jobs();  // the oldest pin is removed by work that the last job's work has asked for
  for (int seed = 10; seed < 20; ++seed) {
    EXPECT_EQ(server.post(seeded(seed), "mesh", kGlb + by("bob")).status, 200);
    server.service.tiers().flush();
  }
  const auto lost = server.get(jobs.front(), by("ana")).json();
  EXPECT_EQ(lost.value("state", ""), "failed") << lost.dump();
  EXPECT_EQ(server.get(results.front(), by("ana")).problem(), "job-lost");
  for (std::size_t k = 1; k < 3; ++k) {
    EXPECT_EQ(server.get(results[k], by("ana")).status, 200) << k;
    EXPECT_EQ(server.get(jobs[k], by("ana")).json().value("state", ""), "done") << k;
  }
}

}  // namespace
}  // namespace fracture::test
