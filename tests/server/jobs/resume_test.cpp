// Jobs of an earlier process resume a few at a time. A job that is refused does not delay others.
#include <gtest/gtest.h>

#include <vector>

#include "server/tenants/account.hpp"
#include "tests/server/support/jobs_host.hpp"

namespace fracture::test {
namespace {

/// The account of a name whose share allows no computations.
std::shared_ptr<tenants::Account> account_over_its_share(const std::string& name) {
  tenants::Tenant tenant;
  tenant.name = name;
  tenant.shares.computations = 0;
  return std::make_shared<tenants::Account>(tenant, true);
}

struct Resume : testing::Test {
  TemporaryFolder folder;
  Gate gate;
  std::atomic<int> asked{
      0};  ///< how often the terms of a job were requested: once for its owner, and once in each attempt
  /// Ana's account is over its share.
  Jobs::TermsOf terms_of() {
    return [this, account = account_over_its_share("ana")](const std::string& owner) {
      ++asked;
      Terms terms;
      if (owner == "ana") terms.payer = {account, {"name ana", 1}};
      return terms;
    };
  }
};

TEST_F(Resume, HowManyEverFinishWhoIsRefusedIsTriedOnceWhenTheDiskComesToIt) {
  leave_job(folder.path, 1, "ana");
  JobsHost host(folder.path);
  host.jobs.resume(terms_of(), [](const JobView&) {});
  host.jobs.flush();
  const int before = asked;
  ASSERT_GE(before, 1);
  // The disk is busy until the gate is open.
  Terms terms;
  terms.deadline = far_off();
  std::atomic<bool> busy{false};
  ASSERT_FALSE(host.jobs.start(fracture_request("mesh", 2), terms, {}, [&](const JobView&) {
    busy = true;
    gate.hook()(Execution());
  }));
  require_eventually(kPatience, "the disk to be busy", [&] { return busy.load(); });
  for (int k = 0; k < 100; ++k) host.jobs.sweep();
  gate.open = true;
  host.idle();
  EXPECT_LE(asked - before, 2) << "that which was queued, and one for the job that has finished";
}

/// The mesh of a job is read only when the job could begin.
TEST_F(Resume, WhoIsOverItsShareCostsTheDiskNothing) {
  const std::string job = leave_job(folder.path, 1, "ana");
  std::filesystem::remove_all(folder / "jobs/meshes");
  JobsHost host(folder.path);
  host.jobs.resume(terms_of(), [](const JobView&) {});
  host.jobs.flush();
  EXPECT_EQ(asked, 2) << "for whose share it counts, and for the attempt";
  EXPECT_EQ(host.find(job).state, JobState::kQueued) << "nobody has missed it yet";
}

/// At most twice as many jobs as threads are resumed, apart from a client's first. They compute while the
/// gate is closed.
TEST_F(Resume, JobsOfOneClientLeaveAPlaceForAnother) {
  for (std::uint64_t seed = 1; seed <= 9; ++seed) leave_job(folder.path, seed, "ana");
  const std::string bobs = leave_job(folder.path, 10, "bob");
  JobsHost host(folder.path);
  host.control->during_cut = gate.hook();
  host.jobs.resume(
      [](const std::string& owner) {
        Terms terms;
        terms.priority = Priority::kBackground;
        terms.deadline = far_off();
        terms.payer.flow = {"name " + owner, 1};
        return terms;
      },
      [](const JobView&) {});
  host.jobs.flush();
  EXPECT_EQ(host.jobs.figures().waiting, 1u) << "ana's last one";
  gate.open = true;
  host.wait_for(bobs, JobState::kDone);
  host.idle();
}

/// As above, but without tokens: the jobs have no owner, and their records name the clients.
TEST_F(Resume, JobsOfOneAddressLeaveAPlaceForAnother) {
  const auto leave = [this](std::uint64_t seed, const std::string& client) {
    return leave_job(folder.path, seed, "", std::chrono::minutes(10), client);
  };
  for (std::uint64_t seed = 1; seed <= 9; ++seed) leave(seed, "address 192.0.2.1");
  const std::string other = leave(10, "address 192.0.2.2");
  JobsHost host(folder.path);
  host.control->during_cut = gate.hook();
  host.resume();
  host.jobs.flush();
  EXPECT_EQ(host.jobs.figures().waiting, 1u) << "the last one of the first client";
  gate.open = true;
  host.wait_for(other, JobState::kDone);
  host.idle();
}

/// A record of algorithm 27 or earlier names no client. Such jobs are resumed as jobs of one common client.
TEST_F(Resume, JobsOfAnEarlierReleaseHaveOneHolder) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) leave_job(folder.path, seed);
  JobsHost host(folder.path);
  host.control->during_cut = gate.hook();
  host.resume();
  host.jobs.flush();
  EXPECT_EQ(host.jobs.figures().waiting, 2u) << "eight of them run, twice as many as threads";
  gate.open = true;
  EXPECT_TRUE(eventually(kPatience, "all jobs", [&] { return host.jobs.figures().unfinished == 0; }));
  host.idle();
  EXPECT_EQ(host.control->cuts, 10);
}

TEST_F(Resume, WhoIsOverItsShareHoldsUpNobodyElse) {
  const std::string anas = leave_job(folder.path, 1, "ana");
  leave_job(folder.path, 2, "ana");
  const std::string bobs = leave_job(folder.path, 3, "bob");
  JobsHost host(folder.path);
  host.jobs.resume(terms_of(), [](const JobView&) {});
  host.wait_for(bobs, JobState::kDone);
  host.idle();
  EXPECT_EQ(host.find(anas).state, JobState::kQueued);
  EXPECT_EQ(host.control->cuts, 1);
}

TEST_F(Resume, AJobThatIsCancelledWhileItIsRefusedIsCancelled) {
  const std::string job = leave_job(folder.path, 1, "ana");
  JobsHost host(folder.path);
  host.jobs.resume(
      [&, terms_of = terms_of()](const std::string& owner) {
        EXPECT_TRUE(host.jobs.cancel(job));
        return terms_of(owner);
      },
      [](const JobView&) {});
  host.wait_for(job, JobState::kCancelled);
  EXPECT_EQ(host.control->cuts, 0);
}

/// The deadline limits the time over all attempts, not in each one.
TEST_F(Resume, TheDeadlineOfAJobRunsFromItsFirstAttemptOn) {
  Crowd crowd;
  const std::string job = leave_job(folder.path, 2, "", std::chrono::seconds(1));
  JobsHost resumed(folder.path);
  crowd.hook(*resumed.control);
  resumed.start(1);  // it takes all of the memory
  require_eventually(kPatience, "the first job to hold its memory", [&] { return crowd.gate.arrived == 1; });
  resumed.resume();
  EXPECT_TRUE(eventually(kPatience, "the job to be given up", [&] {
    resumed.jobs.sweep();
    return resumed.find(job).state == JobState::kFailed;
  }));
  EXPECT_EQ(resumed.find(job).error.value_or(Error{}).code, ErrorCode::kDeadlineExceeded);
  EXPECT_LE(crowd.cuts, 2) << "it has begun once";
}

/// The mesh is read once, and not again before there is enough memory.
TEST_F(Resume, WhoNeedsMoreThanIsFreeCostsTheDiskNothingTwice) {
  const std::string job = leave_job(folder.path, 1);
  JobsHost host(folder.path);
  std::vector<MemoryBudget::Reservation> others;  // until none is left, not even for small ones
  for (const std::uint64_t bytes : {std::uint64_t{64} << 20, std::uint64_t{4} << 10}) do {
      others.emplace_back(host.dispatcher.working());
    } while (others.back().grow_to(bytes));
  host.resume();
  host.jobs.flush();
  std::filesystem::remove_all(folder / "jobs/meshes");
  host.jobs.sweep();
  host.jobs.flush();
  EXPECT_EQ(host.find(job).state, JobState::kQueued) << "nobody has missed it";
}

TEST_F(Resume, AJobThatNeverGetsAPlaceFailsAtItsDeadline) {
  const std::string job = leave_job(folder.path, 1, "ana", std::chrono::milliseconds(100));
  JobsHost host(folder.path);
  host.jobs.resume(terms_of(), [](const JobView&) {});
  EXPECT_TRUE(eventually(kPatience, "the job to be given up", [&] {
    host.jobs.sweep();
    return host.find(job).state == JobState::kFailed;
  }));
  EXPECT_EQ(host.find(job).error.value_or(Error{}).code, ErrorCode::kDeadlineExceeded);
  EXPECT_EQ(host.control->cuts, 0);
}

/// A job whose terms throw is a suspect. If it counted as computing, the other suspect would never go on.
TEST_F(Resume, WhatCannotBeGoneOnWithFailsAndTheOthersGoOn) {
  const std::string bad = leave_job(folder.path, 1, "bad"), worse = leave_job(folder.path, 2, "worse"),
                    good = leave_job(folder.path, 3);
  for (const std::string& job : {bad, good}) folder.write("jobs/begun/" + job, "x");
  JobsHost host(folder.path);
  host.jobs.resume(
      [](const std::string& owner) -> Terms {
        if (owner == "bad") throw std::bad_alloc();
        if (owner == "worse") throw InternalError("an invariant");
        return {};
      },
      [](const JobView&) {});
  host.wait_for(good, JobState::kDone);
  EXPECT_EQ(host.wait_for(bad, JobState::kFailed).error->code, ErrorCode::kOutOfMemory);
  EXPECT_EQ(host.wait_for(worse, JobState::kFailed).error->code, ErrorCode::kInternal);
}

TEST_F(Resume, ASuspectHoldsBackNobodyWhoHasBegunInThisProcess) {
  Crowd crowd;
  const std::string suspect = leave_job(folder.path, 1);
  folder.write("jobs/begun/" + suspect, "x");  // as a process that died leaves it
  JobsHost host(folder.path);
  crowd.hook(*host.control);
  crowd.bytes = 1000;  // This much memory is free.
  host.resume();
  require_eventually(kPatience, "the suspect to run", [&] { return crowd.gate.arrived == 1; });
  const std::string job = host.start(2);
  host.wait_for(job, JobState::kDone);
  EXPECT_LE(crowd.crowdings, 0) << "it was crowded out";
  EXPECT_EQ(host.find(suspect).state, JobState::kRunning);
}

}  // namespace
}  // namespace fracture::test
