// Jobs that wait for memory: others held the memory that they needed, and they begin again when it is free.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "server/tenants/account.hpp"
#include "tests/server/support/jobs_host.hpp"

namespace fracture::test {
namespace {

struct WaitingJob : testing::Test {
  TemporaryFolder folder;
  Crowd crowd;
  std::optional<JobsHost> host;

  /// Runs one job up to the gate and a second one that the first crowds out. Returns both ids. `spoil`
  /// changes the folder once it is in use.
  std::pair<std::string, std::string> crowded_out(
      const std::string& its_folder, const Terms& terms = {}, const std::function<void()>& spoil = [] {}) {
    host.emplace(its_folder);
    spoil();
    crowd.hook(*host->control);
    host->resume();
    const std::string holder = host->start(1);
    require_eventually(kPatience, "the first job to hold its memory",
                       [&] { return crowd.gate.arrived == 1; });
    const std::string job = host->start(2, terms);
    wait_until_it_waits(job);
    return {holder, job};
  }
  void wait_until_it_waits(const std::string& job) {
    require_eventually(kPatience, "a job to be crowded out", [&] { return crowd.crowdings <= 0; });
    host->wait_for(job, JobState::kQueued);
    host->jobs.flush();  // makes another attempt, which is refused
  }
};

TEST_F(WaitingJob, BeginsAgainWhenTheMemoryIsFree) {
  const auto [holder, job] = crowded_out("");
  EXPECT_EQ(host->find(job).state, JobState::kQueued);
  EXPECT_EQ(crowd.cuts, 2);
  crowd.gate.open = true;
  host->wait_for(holder, JobState::kDone);
  host->wait_for(job, JobState::kDone);
  EXPECT_EQ(crowd.cuts, 3);
}

/// The job holds more than half of the working memory, and a client waits for an answer that needs some of
/// it.
TEST_F(WaitingJob, BeginsAgainWhenItsMemoryWasGivenUpForAWaitingClient) {
  host.emplace("");
  std::atomic<int> cuts{0};
  const std::uint64_t memory = host->dispatcher.working().capacity();
  host->control->during_cut = [&, hold = crowd.gate.hook()](const Execution& execution) {
    const bool first = cuts++ == 0;
    execution.made(Product::kImportBytes, memory / 100 * (first ? 70 : 40));
    if (first) hold(execution);
  };
  Terms terms;
  terms.payer.flow = {"ana", 1};
  const std::string job = host->start(1, terms);
  crowd.gate.wait_for(1);
  Terms waits;
  waits.payer.flow = {"bob", 1};
  std::atomic<bool> answered{false};
  EXPECT_FALSE(
      host->dispatcher.fracture(fracture_request("mesh", 2), waits, [&](Expected<FractureAnswer> answer) {
        EXPECT_TRUE(answer) << answer.error().detail;
        answered = true;
      }));
  require_eventually(kPatience, "the answer", [&] { return answered.load(); });
  EXPECT_TRUE(eventually(kPatience, "the job to begin again and end", [&] {
    host->jobs
        .sweep();  // as the server does every ten seconds: at the first attempt the request may still have held its memory
    return host->find(job).state == JobState::kDone;
  }));
  EXPECT_GE(cuts, 3)
      << "the job's, the request's, and the job's again: more if the request still held its memory";
  host->idle();
}

TEST_F(WaitingJob, HoldsUpNoneThatNeedsLess) {
  const auto [holder, large] = crowded_out("");
  crowd.bytes = 1000;
  crowd.crowdings = 1;
  const std::string small = host->start(3);
  host->wait_for(small, JobState::kDone);
  EXPECT_EQ(host->find(large).state, JobState::kQueued);
  crowd.gate.open = true;
  host->wait_for(large, JobState::kDone);
  host->wait_for(holder, JobState::kDone);
}

TEST_F(WaitingJob, BeginsAgainWhenItWasHurriedAndIsOneTooManyNow) {
  const auto host_engine = std::make_shared<FakeControl>();
  std::atomic<int> cuts{0};
  host_engine->cut_error = [&]() -> std::optional<Error> {
    if (cuts++ > 0) return std::nullopt;
    return Error{ErrorCode::kOverloaded, "No more of its class may run."};  // the worker pool's error
  };
  host.emplace("", host_engine);
  host->wait_for(host->start(1), JobState::kDone);
  EXPECT_EQ(cuts, 2);
}

TEST_F(WaitingJob, BeginsAgainThoughItCouldNotBeWrittenDown) {
  const auto [holder, job] = crowded_out(folder.path, {}, [this] {
    const std::filesystem::path meshes = folder / "jobs/meshes";
    std::filesystem::remove_all(meshes);
    std::ofstream(meshes) << "where a folder was";
  });
  EXPECT_FALSE(host->find(job).durable);
  crowd.gate.open = true;
  host->wait_for(holder, JobState::kDone);
  host->wait_for(job, JobState::kDone);
}

TEST_F(WaitingJob, KeepsItsPercent) {
  const auto [holder, job] = crowded_out("");
  const int percent = host->find(job).percent;
  EXPECT_GT(percent, 0) << "it had come to the cut";
  crowd.gate.open = true;
  EXPECT_GE(host->wait_for(job, JobState::kDone).percent, percent);
}

/// A job reserves as much as in any earlier attempt, even if another product is the first to grow this time.
TEST_F(WaitingJob, IsGivenAsMuchAsInAnyAttemptBefore) {
  constexpr std::uint64_t kNeeded = 64u << 20;
  host.emplace();
  crowd.hook(*host->control);
  crowd.crowdings = 2;
  crowd.bytes = kNeeded;
  host->control->during_cut = [this](const Execution& execution) {
    const int attempt = ++crowd.cuts;
    if (attempt == 2) crowd.bytes = 1000;
    if (attempt == 3) crowd.hold(execution);
  };
  const std::string job = host->start(1);
  require_eventually(kPatience, "the third attempt", [&] { return crowd.gate.arrived == 1; });
  EXPECT_GE(host->dispatcher.working().used(), kNeeded);
  crowd.gate.open = true;
  host->wait_for(job, JobState::kDone);
  host->idle();
}

/// Otherwise it would begin only when no other computation holds any memory.
TEST_F(WaitingJob, LeavesAQuarterToOthersIfItNeededLess) {
  host.emplace();
  const std::uint64_t capacity = host->dispatcher.working().capacity();
  crowd.hook(*host->control);
  crowd.bytes = capacity / 10 * 6;
  host->control->during_cut = [this](const Execution& execution) {
    if (++crowd.cuts == 2) crowd.hold(execution);
  };
  const std::string job = host->start(1);
  require_eventually(kPatience, "the second attempt", [&] { return crowd.gate.arrived == 1; });
  EXPECT_GE(host->dispatcher.working().used(), capacity / 10 * 6);
  EXPECT_LE(host->dispatcher.working().used(), capacity / 4 * 3);
  crowd.gate.open = true;
  host->wait_for(job, JobState::kDone);
  host->idle();
}

/// This also holds after the job has been read from the disk.
TEST_F(WaitingJob, IsChargedToWhoeverAskedForIt) {
  tenants::Tenant tenant;
  tenant.name = "ana";
  const auto account = std::make_shared<tenants::Account>(tenant, true);
  Terms terms;
  terms.payer = {account, {"name ana", 1}};
  const auto [holder, job] = crowded_out(folder.path, terms);
  EXPECT_EQ(account->figures().computations, 0u) << "it holds no place while it waits";
  crowd.wait = true;
  EXPECT_TRUE(host->jobs.cancel(holder));
  EXPECT_TRUE(eventually(kPatience, "the job to run again", [&] {
    host->jobs.sweep();
    return crowd.gate.arrived == 2;
  }));
  EXPECT_EQ(account->figures().computations, 1u);
  crowd.gate.open = true;
  host->wait_for(job, JobState::kDone);
}

TEST_F(WaitingJob, IsCancelledThere) {
  const auto [holder, job] = crowded_out("");
  EXPECT_TRUE(host->jobs.cancel(job));
  EXPECT_EQ(host->find(job).state, JobState::kCancelled);
  crowd.gate.open = true;
  host->wait_for(holder, JobState::kDone);
  host->idle();
  EXPECT_EQ(crowd.cuts, 2) << "it does not begin again";
}

/// The job ahead of it in the queue is refused but has time left.
TEST_F(WaitingJob, FailsAtItsDeadlineWhereverItStandsInTheQueue) {
  const auto [holder, first] = crowded_out("");
  ++crowd.crowdings;
  Terms terms;
  terms.deadline = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  const std::string job = host->start(3, terms);
  EXPECT_TRUE(eventually(kPatience, "the job to be given up", [&] {
    host->jobs.sweep();
    return host->find(job).state == JobState::kFailed;
  }));
  const Error error = host->find(job).error.value_or(Error{});
  EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
  EXPECT_NE(error.detail.find("--job-deadline"), std::string::npos);
  EXPECT_EQ(host->find(first).state, JobState::kQueued);
  EXPECT_EQ(host->find(holder).state, JobState::kRunning);
}

/// A drain waits for an unfinished job that the next process would not have.
TEST_F(WaitingJob, ThatIsNotOnTheDiskIsWaitedForByADrain) {
  crowded_out("");
  EXPECT_EQ(host->jobs.figures().unfinished, 2u);
  EXPECT_EQ(host->jobs.figures().waiting, 0u);
}

TEST_F(WaitingJob, OnTheDiskIsNotWaitedForByADrain) {
  crowded_out(folder.path);
  EXPECT_EQ(host->jobs.figures().unfinished, 2u);
  EXPECT_TRUE(eventually(kPatience, "the job to wait after its attempt",
                         [&] { return host->jobs.figures().waiting == 1; }));
}

TEST_F(WaitingJob, OnTheDiskIsThereForTheNextServerWhenItIsCrowdedOutInADrain) {
  std::string job;
  {
    JobsHost draining(folder.path);
    crowd.hook(*draining.control);
    crowd.wait = true;
    draining.resume();
    draining.start(1);
    job = draining.start(2);
    require_eventually(kPatience, "both to run", [&] { return crowd.gate.arrived == 2; });
    draining.jobs.stop_resuming();
    crowd.gate.open = true;  // The first one to end is crowded out.
    EXPECT_TRUE(eventually(kPatience, "the other one to be done", [&] {
      return draining.jobs.figures().unfinished == draining.jobs.figures().waiting;
    }));
    EXPECT_EQ(draining.jobs.figures().waiting, 1u);
  }
  JobsHost next(folder.path);
  next.resume();
  for (const JobView& view : next.jobs.list({}, 10)) next.wait_for(view.id, JobState::kDone);
  EXPECT_EQ(next.control->cuts, 1);
  EXPECT_EQ(next.wait_for(job, JobState::kDone).percent, 100);
}

/// The computation reports a lack of memory after it was told to stop, but before it noticed.
TEST_F(WaitingJob, OnTheDiskIsThereForTheNextServerWhenItIsCrowdedOutWhileThatStops) {
  std::string first, job;
  {
    Gate gate;  // for the second job
    JobsHost stopping(folder.path);
    crowd.hook(*stopping.control);
    stopping.control->during_cut = [&, hold = gate.hook()](const Execution& execution) {
      crowd.cuts++ == 0 ? crowd.hold(execution) : hold(execution);
    };
    stopping.resume();
    first = stopping.start(1);
    require_eventually(kPatience, "the first job to run", [&] { return crowd.gate.arrived == 1; });
    job = stopping.start(2);
    require_eventually(kPatience, "the second job to run", [&] { return gate.arrived == 1; });
    // stop() first notifies the first job, and its watcher opens the gate.
    const auto seen = stopping.find(first).version;
    EXPECT_TRUE(stopping.jobs.watch(first, seen, [&](const JobView&) {
      gate.open = true;
      EXPECT_TRUE(eventually(kPatience, "the second job to end",
                             [&] { return stopping.find(job).state != JobState::kRunning; }));
    }));
    stopping.jobs.stop();
    EXPECT_LE(crowd.crowdings, 0) << "it was crowded out";
    EXPECT_EQ(stopping.find(job).state, JobState::kQueued);
  }
  JobsHost next(folder.path);
  next.resume();
  for (const std::string& id : {first, job}) next.wait_for(id, JobState::kDone);
}

}  // namespace
}  // namespace fracture::test
