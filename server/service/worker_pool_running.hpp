// A job of the worker pool on its thread: for the files of the pool.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>

#include "common/base/execution.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture {

using Seconds = std::chrono::duration<double>;

inline constexpr std::array kPriorities = {Priority::kRealtime, Priority::kBatch, Priority::kBackground};

/// A job on its thread. Everything that is not said to be otherwise is guarded by the pool's mutex.
class WorkerPool::Running final : public Turn {
 public:
  Running(WorkerPool& its_pool, Priority its_priority, double its_cost, Priority its_place)
      : pool(its_pool), priority(its_priority), cost(its_cost), began(its_place) {}

  void give_way() override {
    // All threads of a job stand still, also those that poll when the first of them has made room already.
    if (!concerns_it()) return;
    std::unique_lock lock(pool.mutex_);
    end_if_too_many();
    if (priority == Priority::kRealtime) return;
    if (!paused) {
      if (Clock::now() < works_until || !pool.must_stand_back(priority)) return;
      paused = true;
      paused_since = Clock::now();
      pool.changed();
    }
    // Every thread of the job waits here; the first that may go on lets all of them.
    pool.go_on_.wait_until(lock, paused_since + kLongestPause, [this] {
      return !paused || must_end || priority == Priority::kRealtime || pool.stopping_ ||
             pool.may_go_on(priority);
    });
    if (!paused) return end_if_too_many();
    paused = false;
    const Clock::duration stood = Clock::now() - paused_since;
    paused_for += stood;
    works_until = Clock::now() + std::max<Clock::duration>(kLeastWork, stood / 4);
    pool.go_on_.notify_all();
    pool.changed();
    end_if_too_many();
  }

  void end_where_it_must() override {
    if (!concerns_it()) return;
    const std::lock_guard lock(pool.mutex_);
    end_if_too_many();
  }

  void leave() override {
    const std::lock_guard lock(pool.mutex_);
    away = true;
    pool.changed();
  }

  void come_back() override {
    const std::lock_guard lock(pool.mutex_);
    away = false;
    pool.changed();
  }

  void spent_elsewhere(double seconds) override { elsewhere += seconds; }

  bool is_urgent() const override {
    const std::lock_guard lock(pool.mutex_);
    return priority == Priority::kRealtime;
  }

  /// Read at every poll, without the lock.
  bool concerns_it() const {
    return pool.urgent_.load(std::memory_order_relaxed) || paused.load(std::memory_order_relaxed) ||
           must_end.load(std::memory_order_relaxed) || pool.some_class_ended();
  }
  void end_if_too_many() const {
    if (pool.some_class_ended()) pool.changed();
    if (must_end)
      throw Interrupted(Error{.code = ErrorCode::kOverloaded,
                              .detail =
                                  "This computation is less urgent than it was, and as many of its class run "
                                  "as may. Ask again.",
                              .retry_after = std::chrono::seconds(1)});
  }

  /// When it is of its class no longer, where nothing changes.
  Clock::time_point class_ends() const {
    const auto of = static_cast<std::size_t>(priority);
    return priority == Priority::kBackground ? Clock::time_point::max()
                                             : since + (pool.longest_[of] - spent[of]);
  }

  /// Realtime work keeps its processor while it is away.
  bool computes() const { return !paused && (!away || priority == Priority::kRealtime); }

  WorkerPool& pool;
  Priority priority;
  double cost;
  const Priority began;  ///< the class whose place it has
  const Clock::time_point start = Clock::now();
  std::atomic<bool> paused{false}, must_end{false};  // read at every poll, without the lock
  Clock::time_point since = start;                   // it is of its class
  std::array<Clock::duration, 3> spent{};            // in each class, before that
  bool away = false;
  Clock::time_point paused_since{}, works_until{};
  Clock::duration paused_for{};
  // Of the job's own thread alone.
  double elsewhere = 0;  ///< processor seconds of other processes

  static thread_local Running* of_this_thread;
};

}  // namespace fracture
