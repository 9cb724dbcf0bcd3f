// Working memory that is set aside for answers until they are read (Dispatcher::set_aside).
#include "tests/server/service/dispatcher_fixture.hpp"

namespace fracture::test {
namespace {

using Verdict = MemoryBudget::Verdict;

struct SetAside : DispatcherTest {
  static constexpr std::uint64_t kMebibyte = 1u << 20;
  Dispatcher small{service, pool, {64 * kMebibyte}};  // 56 MiB for large reservations, which exceed 8 MiB
  Gate gate;
  std::atomic<int> cuts{0}, ended{0};
  std::atomic<bool> gave_way{false};

  Verdict set_aside(std::uint64_t mebibytes, std::shared_ptr<const void>& aside) {
    return small.set_aside("bob", mebibytes * kMebibyte, aside);
  }
  /// A job of ana, which needs 40 MiB if it is the first one.
  void begin_job(std::uint64_t seed) {
    control->during_cut = [this](const Execution& execution) {
      if (cuts++ > 0) return;
      execution.made(Product::kImportBytes, 40 * kMebibyte);
      gate.pass(execution);
    };
    Terms terms;
    terms.priority = Priority::kBackground;
    terms.payer.flow = {"ana", 1};
    const auto refused =
        small.fracture(fracture_request("mesh", seed), terms, [this](Expected<FractureAnswer> answer) {
          if (!answer) gave_way = answer.error().code == ErrorCode::kOverloaded;
          ++ended;
        });
    EXPECT_FALSE(refused) << refused->detail;
  }
};

TEST_F(SetAside, MakesJobsGiveUpTheirMemory) {
  begin_job(1);
  gate.wait_for(1);
  require_eventually(kPatience, "the job to hold its memory",
                     [this] { return small.working().used() >= 40 * kMebibyte; });
  std::shared_ptr<const void> aside;
  EXPECT_EQ(set_aside(20, aside), Verdict::kHeldInBackground);
  EXPECT_FALSE(aside);
  require_eventually(kPatience, "the job to end", [this] { return ended == 1; });
  EXPECT_TRUE(gave_way) << "it begins again later";
  require_eventually(kPatience, "its memory to come back", [this] { return small.working().used() == 0; });
  EXPECT_EQ(set_aside(20, aside), Verdict::kFits);
  EXPECT_EQ(small.working().used(), 20 * kMebibyte);
  aside = nullptr;
  begin_job(2);
  small.wait_idle();
  EXPECT_EQ(ended, 2) << "also if it had to wait because of the answer";
  EXPECT_EQ(small.working().used(), 0u);
}

TEST_F(SetAside, LeavesThePartForSmallComputationsFree) {
  MemoryBudget::Reservation large(small.working());
  ASSERT_TRUE(large.grow_to(54 * kMebibyte));
  std::shared_ptr<const void> first, second;
  EXPECT_EQ(set_aside(4, first), Verdict::kFull);
  EXPECT_FALSE(first);
  EXPECT_EQ(set_aside(2, first), Verdict::kFits);
  EXPECT_EQ(set_aside(1, second), Verdict::kFull);
  MemoryBudget::Reservation collision(small.working());
  EXPECT_TRUE(collision.grow_to(8 * kMebibyte));
}

TEST_F(SetAside, AlsoMakesJobsGiveWayToASmallAnswer) {
  MemoryBudget::Reservation jobs(small.working(), MemoryBudget::Use::kBackground);
  ASSERT_TRUE(jobs.grow_to(54 * kMebibyte));
  std::shared_ptr<const void> aside;
  EXPECT_EQ(set_aside(4, aside), Verdict::kHeldInBackground);
  EXPECT_FALSE(aside);
}

}  // namespace
}  // namespace fracture::test
