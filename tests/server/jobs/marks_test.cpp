// The mark of a job that has begun is on the disk only while this process computes the job.
#include <gtest/gtest.h>

#include "tests/server/support/jobs_host.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

std::string mark_of(const TemporaryFolder& folder, const std::string& job) {
  return folder / "jobs/begun/" + job;
}

TEST(Marks, AJobThatWasStoppedHasNoneThoughOthersStillWaitForItsComputation) {
  const TemporaryFolder folder;
  Gate gate;
  JobsHost host(folder.path);
  host.control->during_cut = gate.hook();
  const std::string job = host.start(1);
  require_eventually(kPatience, "the job to run", [&] { return gate.arrived == 1; });
  std::atomic<int> answers{0};
  EXPECT_FALSE(
      host.dispatcher.fracture(fracture_request("mesh", 1), {},
                               [&](Expected<FractureAnswer> answer) { answers += answer.has_value(); }));
  EXPECT_EQ(host.dispatcher.figures().collapsed, 1u);
  host.jobs.stop();
  gate.open = true;
  host.idle();
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(host.find(job).state, JobState::kQueued) << "the next server goes on with it";
  EXPECT_FALSE(fs::exists(mark_of(folder, job)));
}

/// The job is stopped just before its thread leaves the mark.
TEST(Marks, AreTakenBackAfterTheyWereLeft) {
  const TemporaryFolder folder;
  const std::string job = leave_job(folder.path, 1);
  JobsHost host(folder.path);
  Gate computes, marks;
  host.control->during_cut = computes.hook();
  host.before_mark = [hook = marks.hook()] { hook({}); };
  host.resume();
  require_eventually(kPatience, "the job's thread to come to its mark", [&] { return marks.arrived == 1; });
  host.jobs.stop();
  host.jobs.flush();
  EXPECT_EQ(host.find(job).state, JobState::kQueued);
  EXPECT_FALSE(fs::exists(mark_of(folder, job))) << "it is not left yet";
  marks.open = computes.open = true;
  host.idle();
  EXPECT_FALSE(fs::exists(mark_of(folder, job)));
}

}  // namespace
}  // namespace fracture::test
