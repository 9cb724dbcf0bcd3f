// A server that starts while another one owns the folder. It is not ready and does not have the folder's jobs
// until the other server releases the folder. Then it takes over folder and jobs, and resumes the jobs.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/server/support/jobs_host.hpp"

namespace fracture::test {
namespace {

std::string metric(TestServer& server, const std::string& name) {
  const std::string text = ask(server.server.admin_port(), "GET", "/metrics").body;
  const std::size_t at = text.find("\n" + name + " ");
  return at == std::string::npos ? "none" : text.substr(at + name.size() + 2, 1);
}

int readiness(TestServer& server) { return ask(server.server.admin_port(), "GET", "/readyz").status; }

struct Handover : testing::Test {
  TemporaryFolder folder;
  const std::string tier_up = "fracture_cache_tier_up{cache=\"result\",tier=\"disk\"}";
};

TEST_F(Handover, TheSecondServerIsReadyWhenItHasTheFolderWithItsJobsAndResults) {
  Gate gate;
  TestServerOptions options = durable(folder);
  options.control = std::make_shared<FakeControl>();
  options.control->during_cut = gate.hook();
  auto first = std::make_unique<TestServer>(options);
  gate.open = true;
  const std::string done = first->post("/fracture?seed=1", "a mesh", kAsync).json().at("id");
  wait_for_state(*first, "/jobs/" + done, "done");
  first->api.flush_jobs();
  gate.open = false;
  const std::string open = first->post("/fracture?seed=2", "a mesh", kAsync).json().at("id");
  wait_for_state(*first, "/jobs/" + open, "running");

  TestServer second(durable(folder));
  EXPECT_TRUE(second.api.waits_for_folder());
  EXPECT_EQ(second.api.take_folder(), false);
  EXPECT_EQ(readiness(second), 503);
  EXPECT_EQ(metric(second, "fracture_ready"), "0");
  EXPECT_EQ(metric(second, tier_up), "0");
  for (const std::string& job : {done, open}) {
    const Reply unknown = second.get("/jobs/" + job);
    EXPECT_EQ(unknown.status, 503) << "404 would say that a promised job is lost";
    EXPECT_FALSE(unknown.header("retry-after").empty());
  }
  EXPECT_EQ(second.post("/fracture?seed=3").status, 200) << "who asks all the same is answered";
  const nlohmann::json early = second.post("/fracture?seed=4", "a mesh", kAsync).json();
  EXPECT_EQ(early.at("durable"), false);
  wait_for_state(second, "/jobs/" + early.at("id").get<std::string>(), "done");
  EXPECT_EQ(readiness(*first), 200);

  first->api.stop_jobs();  // as a server does that is told to stop
  gate.open = true;
  first.reset();
  EXPECT_EQ(second.api.take_folder(), true);
  EXPECT_FALSE(second.api.waits_for_folder());
  EXPECT_EQ(readiness(second), 200);
  EXPECT_EQ(metric(second, "fracture_ready"), "1");
  EXPECT_EQ(metric(second, tier_up), "1");
  wait_for_state(second, "/jobs/" + open, "done");
  const nlohmann::json kept = second.get("/jobs/" + done).json();
  EXPECT_EQ(kept.at("state"), "done");
  EXPECT_EQ(second.get(kept.at("result").get<std::string>()).header("cache-status").substr(0, 9),
            "disk; hit");
  EXPECT_EQ(second.post("/fracture?seed=5", "a mesh", kAsync).json().at("durable"), true);
  EXPECT_EQ(second.get("/jobs/" + std::string("0123456789abcdef-0123456789abcdef")).status, 404);
  const nlohmann::json list = second.get("/jobs").json().at("jobs");
  ASSERT_EQ(list.size(), 4u);
  for (std::size_t k = 1; k < list.size(); ++k)
    EXPECT_GT(list[k - 1].at("created").get<std::string>(), list[k].at("created").get<std::string>())
        << "the newest first, whoever took them";
}

/// A finished job is useless without its result, so the folder of jobs is not taken before the disk tier's
/// folder.
TEST_F(Handover, TheFolderOfTheJobsComesAfterTheOneOfTheResults) {
  std::string job;
  {
    JobsHost host(folder.path);
    job = host.start(1);
    host.wait_for(job, JobState::kDone);
    host.idle();
  }
  auto tier = std::make_unique<DiskCache>(folder.path, 1u << 30);
  JobsHost next(folder.path);
  EXPECT_EQ(next.jobs.take_folder(), false) << "though nobody has it";
  EXPECT_FALSE(next.jobs.find(job));
  tier.reset();
  EXPECT_EQ(next.service.tiers().take_folder(), true);
  EXPECT_EQ(next.jobs.take_folder(), true);
  EXPECT_EQ(next.find(job).state, JobState::kDone);
}

/// From a machine with a wrong clock, or forged.
TEST_F(Handover, AJobOfTheFutureSaysNothingAboutTheTimeOfLaterOnes) {
  const std::string old = leave_job(folder.path, 1);
  {
    JobFolder jobs({folder / "jobs"});
    ASSERT_EQ(jobs.take(), true);
    JobRecord record = jobs.read(old).value();
    record.created += std::chrono::hours(24 * 365 * 1000);
    record.state = JobState::kFailed;
    record.error = Error{ErrorCode::kInternal, "x"};
    ASSERT_TRUE(jobs.write_end(record));
  }
  JobsHost host(folder.path);
  const std::string made = host.start(2);
  EXPECT_LT(host.find(made).created, host.find(old).created);
  EXPECT_LT(host.find(made).created, std::chrono::system_clock::now() + std::chrono::hours(1));
  const auto list = host.jobs.list({}, 10);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].id, old) << "in the order of their times, by which a client asks for the next page";
}

}  // namespace
}  // namespace fracture::test
