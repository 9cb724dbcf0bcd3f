#include "common/base/execution.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <stop_token>
#include <thread>
#include <vector>

namespace fracture {
namespace {

TEST(ParallelFor, CoversEveryItemOnceWithTheSameBlocksForAnyThreadCount) {
  std::set<std::pair<std::size_t, std::size_t>> reference;
  for (const int threads : {1, 2, 7}) {
    Execution execution;
    execution.threads = threads;
    std::vector<int> visits(1003, 0);
    std::set<std::pair<std::size_t, std::size_t>> blocks;
    std::mutex mutex;
    parallel_for(execution, visits.size(), 10, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
      const std::lock_guard lock(mutex);
      blocks.emplace(begin, end);
    });
    for (const int v : visits) ASSERT_EQ(v, 1);
    if (reference.empty()) reference = blocks;
    EXPECT_EQ(blocks, reference) << threads << " threads";
  }
}

TEST(ParallelFor, DoesNothingForNoItemsAndAcceptsAGrainOfZero) {
  int calls = 0;
  parallel_for({}, 0, 5, [&](std::size_t, std::size_t) { ++calls; });
  EXPECT_EQ(calls, 0);
  parallel_for({}, 3, 0, [&](std::size_t begin, std::size_t end) { calls += static_cast<int>(end - begin); });
  EXPECT_EQ(calls, 3);
}

TEST(ParallelFor, RethrowsAnExceptionOfABlockAfterAllWorkersHaveStopped) {
  for (const int threads : {1, 4}) {
    Execution execution;
    execution.threads = threads;
    std::atomic<int> running{0};
    EXPECT_THROW(parallel_for(execution, 1000, 1,
                              [&](std::size_t begin, std::size_t) {
                                ++running;
                                if (begin == 100) {
                                  --running;
                                  throw InternalError("block 100");
                                }
                                --running;
                              }),
                 InternalError);
    EXPECT_EQ(running, 0);
  }
}

TEST(ParallelFor, RunsInsideItselfAndFromManyThreadsAtOnce) {
  Execution execution;
  execution.threads = 3;
  std::vector<std::thread> callers;
  std::vector<std::size_t> sums(8, 0);
  for (std::size_t c = 0; c < sums.size(); ++c)
    callers.emplace_back([&, c] {
      for (int round = 0; round < 50; ++round) {
        std::atomic<std::size_t> sum{0};
        parallel_for(execution, 10, 1, [&](std::size_t outer, std::size_t) {
          parallel_for(execution, 10, 1, [&](std::size_t inner, std::size_t) { sum += 10 * outer + inner; });
        });
        sums[c] += sum;
      }
    });
  for (std::thread& t : callers) t.join();
  for (const std::size_t sum : sums) EXPECT_EQ(sum, 50u * (99 * 100 / 2));
}

TEST(ParallelFor, WaitsForTheHelpersThatAreStillAtWork) {
  Execution execution;
  execution.threads = 2;
  for (int round = 0; round < 200; ++round) {
    std::atomic<int> begun{0}, ended{0};
    parallel_for(execution, 2, 1, [&](std::size_t, std::size_t) {
      ++begun;
      std::this_thread::yield();
      ++ended;
    });
    EXPECT_EQ(begun, 2);
    EXPECT_EQ(ended, 2);
  }
}

TEST(ParallelFor, StopsWhenCancelled) {
  std::stop_source source;
  Execution execution;
  execution.threads = 2;
  execution.stop = source.get_token();
  std::atomic<int> blocks{0};
  try {
    parallel_for(execution, 100000, 1, [&](std::size_t, std::size_t) {
      if (++blocks == 50) source.request_stop();
    });
    FAIL() << "not interrupted";
  } catch (const Interrupted& interrupted) {
    EXPECT_EQ(interrupted.code, ErrorCode::kCancelled);
  }
  EXPECT_LT(blocks, 100000);
}

/// The stop flag of a caller that has no std::stop_token.
struct FlagToken {
  const std::atomic<bool>* flag;
  bool stop_requested() const { return *flag; }
};

TEST(Execution, AnyTokenThatCanBeAskedStopsIt) {
  Execution execution;
  EXPECT_FALSE(execution.stop.stop_requested());
  std::atomic<bool> flag{false};
  execution.stop = FlagToken{&flag};
  const Execution copy = execution;
  EXPECT_NO_THROW(copy.poll());
  flag = true;
  EXPECT_TRUE(execution.stop.stop_requested());
  EXPECT_THROW(copy.poll(), Interrupted);
}

TEST(Execution, PollThrowsPastTheDeadline) {
  Execution execution;
  EXPECT_NO_THROW(execution.poll());
  execution.deadline = std::chrono::steady_clock::now() + std::chrono::hours(1);
  EXPECT_NO_THROW(execution.poll());
  execution.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  try {
    execution.poll();
    FAIL() << "not interrupted";
  } catch (const Interrupted& interrupted) {
    EXPECT_EQ(interrupted.code, ErrorCode::kDeadlineExceeded);
  }
}

/// The reports of a stage, in order.
struct Told {
  std::mutex mutex;
  std::vector<double> fractions;
  StageProgress::Tell tell = [this](Stage, double fraction) {
    const std::lock_guard lock(mutex);
    fractions.push_back(fraction);
  };
};

TEST(StageProgress, GrowsWithEveryLoopAndStaysWithinItsPart) {
  Told told;
  StageProgress stage(Stage::kClip, told.tell);
  Execution execution;
  execution.within = &stage;
  execution.reaches(0.5);
  for (int loop = 0; loop < 50; ++loop) parallel_for(execution, 1000, 1, [](std::size_t, std::size_t) {});
  ASSERT_GE(told.fractions.size(), 50u * 32);
  EXPECT_LE(told.fractions.size(), 50u * 64 + 1) << "some tens of times for each loop, whatever its blocks";
  EXPECT_TRUE(std::is_sorted(told.fractions.begin(), told.fractions.end()));
  EXPECT_GT(told.fractions[40], 0.1) << "a long loop takes a good part of what is left";
  EXPECT_LE(told.fractions.back(), 0.5);
  execution.reaches(0.8);
  EXPECT_EQ(told.fractions.back(), 0.5) << "the next part begins where this one was to end";
  for (int again = 0; again < 20; ++again) {
    execution.reaches(0.3);
    parallel_for(execution, 1000, 1, [](std::size_t, std::size_t) {});
  }
  EXPECT_TRUE(std::is_sorted(told.fractions.begin(), told.fractions.end())) << "never back";
  EXPECT_LT(told.fractions.back(), 1);
}

TEST(StageProgress, APartIsDividedInItselfAndTheNextBeginsAtItsEnd) {
  Told told;
  StageProgress stage(Stage::kTetrahedralize, told.tell);
  Execution execution;
  execution.within = &stage;
  for (int pass = 0; pass < 4; ++pass) {
    const std::size_t before = told.fractions.size();
    const StageProgress::Part part(execution.within, (pass + 1) / 4.0);
    for (const double end : {0.3, 0.6, 1.0}) {
      execution.reaches(end);
      parallel_for(execution, 1000, 1, [](std::size_t, std::size_t) {});
    }
    EXPECT_EQ(told.fractions[before], pass / 4.0);
    EXPECT_LT(told.fractions.back(), (pass + 1) / 4.0);
    EXPECT_GT(told.fractions.back(), (pass + 0.6) / 4.0);
  }
  EXPECT_TRUE(std::is_sorted(told.fractions.begin(), told.fractions.end()));
}

TEST(StageProgress, OnlyTheOuterOfTwoLoopsTellsAndWhoIsNotAskedTellsNothing) {
  Told told;
  StageProgress stage(Stage::kClip, told.tell);
  Execution execution;
  execution.threads = 3;
  execution.within = &stage;
  parallel_for(execution, 8, 1, [&](std::size_t, std::size_t) {
    parallel_for(execution, 1000, 1, [](std::size_t, std::size_t) {});
  });
  EXPECT_EQ(told.fractions.size(), 8u);
  const StageProgress::Tell nobody;
  StageProgress unheard(Stage::kClip, nobody);
  execution.within = &unheard;
  parallel_for(execution, 8, 1, [](std::size_t, std::size_t) {});
  execution.reaches(1);
}

}  // namespace
}  // namespace fracture
