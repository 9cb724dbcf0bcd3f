// What an earlier process left goes on a few at a time, and who is refused holds up nobody else.
#include <gtest/gtest.h>

#include "server/tenants/account.hpp"
#include "tests/server/jobs_host.hpp"

namespace fracture::test {
namespace {

/// Of a name that may have no computation now.
std::shared_ptr<tenants::Account> account_over_its_share(const std::string& name) {
  tenants::Tenant tenant;
  tenant.name = name;
  tenant.shares.computations = 0;
  return std::make_shared<tenants::Account>(tenant, true);
}

struct Resume : testing::Test {
  TemporaryFolder folder;
  Gate gate;
  std::atomic<int> asked{0};  ///< for the terms of a job, once in each attempt to go on with it
  /// Ana is over her share.
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

/// Its mesh is read when it could begin.
TEST_F(Resume, WhoIsOverItsShareCostsTheDiskNothing) {
  const std::string job = leave_job(folder.path, 1, "ana");
  std::filesystem::remove_all(folder / "jobs/meshes");
  JobsHost host(folder.path);
  host.jobs.resume(terms_of(), [](const JobView&) {});
  host.jobs.flush();
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(host.find(job).state, JobState::kQueued) << "nobody has missed it yet";
}

}  // namespace
}  // namespace fracture::test
