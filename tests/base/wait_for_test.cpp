#include "common/base/wait_for.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "common/base/descriptor.hpp"

namespace fracture {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

struct WaitForTest : testing::Test {
  Descriptor reads, writes;

  void SetUp() override {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    reads = Descriptor(ends[0]);
    writes = Descriptor(ends[1]);
  }
};

TEST_F(WaitForTest, SaysWhatIsReady) {
  EXPECT_EQ(wait_for(writes.get(), POLLOUT, Clock::now() + hours(1)), POLLOUT);
  ASSERT_EQ(::write(writes.get(), "x", 1), 1);
  EXPECT_EQ(wait_for(reads.get(), POLLIN, Clock::now() + hours(1)), POLLIN);
}

TEST_F(WaitForTest, EndsWhenTheOtherEndIsClosed) {
  writes.reset();
  EXPECT_NE(wait_for(reads.get(), POLLIN, Clock::now() + hours(1)) & POLLHUP, 0);
}

TEST_F(WaitForTest, EndsAtTheDeadline) {
  const Clock::time_point deadline = Clock::now() + milliseconds(5);
  EXPECT_EQ(wait_for(reads.get(), POLLIN, deadline), 0);
  EXPECT_EQ(errno, ETIMEDOUT);
  EXPECT_GE(Clock::now(), deadline);
}

TEST_F(WaitForTest, ADeadlineThatHasPassedIsOneEvenIfTheDescriptorIsReady) {
  EXPECT_EQ(wait_for(writes.get(), POLLOUT, Clock::now() - milliseconds(1)), 0);
  EXPECT_EQ(errno, ETIMEDOUT);
}

}  // namespace
}  // namespace fracture
