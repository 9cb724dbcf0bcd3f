#include "common/base/processor_time.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "common/base/execution.hpp"
#include "tests/support/eventually.hpp"

namespace fracture {
namespace {

void spend(double seconds) {
  const double begin = processor_seconds_of_this_thread();
  while (processor_seconds_of_this_thread() < begin + seconds) {
  }
}

TEST(ProcessorTime, CountsWorkAndNotSleep) {
  const double begin = processor_seconds_of_this_thread();
  // pause: sleeping must not count as processor time
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_LT(processor_seconds_of_this_thread() - begin, 0.05);
  spend(0.02);
  EXPECT_GE(processor_seconds_of_this_thread() - begin, 0.02);
}

TEST(ProcessorTime, WhatHelpersDoInALoopIsCountedForWhoseLoopItIs) {
  Execution execution;
  execution.threads = 4;
  std::atomic<int> at_work{0};
  const double begin = processor_seconds_of_this_thread();
  parallel_for(execution, 4, 1, [&](std::size_t, std::size_t) {
    ++at_work;
    test::require_eventually(test::kPatience, "four threads, a block each", [&] { return at_work == 4; });
    spend(0.02);
  });
  EXPECT_GE(processor_seconds_of_this_thread() - begin, 0.08);
}

}  // namespace
}  // namespace fracture
