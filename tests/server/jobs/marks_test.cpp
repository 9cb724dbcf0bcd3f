// The mark of a job that has begun is on the disk only while this process computes the job.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

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

/// The job is stopped just before its thread leaves the mark. The mark is a pipe: a thread that opens it for
/// writing blocks until it is opened for reading.
TEST(Marks, AreTakenBackAfterTheyWereLeft) {
  struct Descriptor {
    ~Descriptor() {
      if (number >= 0) ::close(number);
    }
    int number = -1;
  };
  const TemporaryFolder folder;
  const std::string job = leave_job(folder.path, 1);
  Gate gate;
  Descriptor reading;  // open until there are no writers
  JobsHost host(folder.path);
  host.control->during_cut = gate.hook();
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  ASSERT_EQ(::link((folder / "pipe").c_str(), mark_of(folder, job).c_str()), 0);
  host.resume();
  host.wait_for(job, JobState::kRunning);
  host.jobs.stop();
  host.jobs.flush();
  EXPECT_EQ(host.find(job).state, JobState::kQueued);
  EXPECT_TRUE(fs::exists(mark_of(folder, job))) << "it is not there yet, and nobody has taken it back";
  reading.number = ::open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK);
  host.idle();
  EXPECT_FALSE(fs::exists(mark_of(folder, job)));
}

}  // namespace
}  // namespace fracture::test
