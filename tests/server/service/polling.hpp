// Computations in the worker pool that a test begins, watches and ends.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "common/base/execution.hpp"
#include "server/service/worker_pool.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

inline constexpr Priority kRealtime = Priority::kRealtime, kBatch = Priority::kBatch,
                          kBackground = Priority::kBackground;

/// Polls until it is told to end or is interrupted.
struct Polling {
  explicit Polling(WorkerPool& pool, int threads = 1, Priority priority = kBatch) {
    id = pool.submit(priority, 0, [this, threads](int) {
      Turn* const turn = WorkerPool::turn();
      std::vector<std::thread> helpers;
      const auto work = [this, turn] {
        try {
          while (!end) {
            turn->give_way();
            ++polls;
            std::this_thread::yield();
          }
        } catch (const Interrupted& interrupted) {
          ended_by = interrupted.code;
          was_ended = true;
        }
      };
      for (int k = 1; k < threads; ++k) helpers.emplace_back(work);
      work();
      for (std::thread& helper : helpers) helper.join();
      paused_seconds = WorkerPool::paused_seconds();
      done = true;
    });
  }
  ~Polling() {
    end = true;
    EXPECT_TRUE(eventually(kPatience, "the job to end", [&] { return done.load(); }));
  }
  /// Waits until it has begun.
  void wait() const {
    EXPECT_TRUE(eventually(kPatience, "the job to begin", [&] { return polls > 0; }));
  }
  WorkerPool::TaskId id = 0;
  std::atomic<bool> end{false}, done{false}, was_ended{false};
  std::atomic<ErrorCode> ended_by{ErrorCode::kInternal};
  std::atomic<long> polls{0};
  double paused_seconds = 0;
};

/// A computation that has begun.
struct Computing : Polling {
  explicit Computing(WorkerPool& pool, int threads = 1, Priority priority = kBatch)
      : Polling(pool, threads, priority) {
    wait();
  }
};

}  // namespace fracture::test
