// A running job of the worker pool. Only the pool's own files include this header.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <new>
#include <utility>

#include "common/base/execution.hpp"
#include "common/base/processor_time.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture {

using Seconds = std::chrono::duration<double>;

/// A job that runs on its thread. The pool's mutex guards all members, unless stated otherwise.
class WorkerPool::Running final : public Turn {
 public:
  Running(WorkerPool& its_pool, Client& its_client, Priority its_priority, Priority its_place)
      : pool(its_pool), client(its_client), priority(its_priority), began(its_place) {}

  void give_way() override {
    if (of_this_thread == this) tick();
    // All threads of a job stand still, even those that poll after the first one has made room.
    if (!concerns_it()) return;
    std::unique_lock lock(pool.mutex_);
    end_if_too_many();
    if (away || (!paused && !asked)) return;
    if (!paused) stop();
    // Every thread of the job waits here. They all continue together.
    while (paused && !must_end && !unwanted()) {
      go_on.wait_for(lock, kLook);
      pool.schedule();  // it may have stood still long enough, or its client may be within its rate again
    }
    end_if_too_many();
  }

  void end_where_it_must() override {
    if (of_this_thread == this) tick();
    if (!must_end.load(std::memory_order_relaxed)) return;
    const std::lock_guard lock(pool.mutex_);
    end_if_too_many();
  }

  void leave() override { set_away(true); }
  void come_back() override { set_away(false); }
  void spent_elsewhere(double seconds) override { elsewhere += seconds; }

  bool is_urgent() const override {
    const std::lock_guard lock(pool.mutex_);
    return priority == Priority::kRealtime;
  }

  /// Charges what the job has used since the last call. Must be called on the job's own thread, without the lock.
  void charge() {
    const double now = processor_seconds_of_this_thread() + elsewhere;
    const double used = now - std::exchange(charged, now);
    if (!(used > 0)) return;
    {
      const std::lock_guard lock(pool.mutex_);
      used_at = Clock::now();
      used_by_now += used;
    }
    try {
      if (task.used)
        task.used(used);
      else
        pool.charge(priority_of_charge(), task.flow, used);
    } catch (const std::bad_alloc&) {  // without memory to store the client, it is not charged
    }
  }

  bool computes() const { return !paused && !away; }
  bool is_protected(Clock::time_point now) const { return now < works_until; }
  bool is_held() const { return pool.is_held(task.flow, task.shared); }
  double key() const { return client.key(priority); }
  Clock::duration stood(Clock::time_point now) const {
    return paused ? now - paused_since : Clock::duration(0);
  }

  /// Returns when the job will leave its class if nothing changes.
  Clock::time_point class_ends() const {
    const auto of = static_cast<std::size_t>(priority);
    return priority == Priority::kBackground ? Clock::time_point::max()
                                             : since + (pool.longest_[of] - spent[of]);
  }

  void stop() {
    paused = true;
    asked = false;
    paused_since = Clock::now();
    pool.schedule();
  }
  void start_again() {
    const Clock::time_point now = Clock::now();
    const Clock::duration time = stood(now);
    paused = false;
    paused_for += time;
    if (time >= kLongestPause) works_until = now + kLeastWork;
    go_on.notify_all();
  }

  WorkerPool& pool;
  Client& client;
  Task task{};
  Priority priority;
  const Priority began;  ///< the class in which it occupies a place
  const Clock::time_point start = Clock::now();
  std::atomic<bool> asked{false}, paused{false}, must_end{false};  // polls read them without the lock
  std::condition_variable go_on{};
  Clock::time_point since = start;         // when it entered its class
  std::array<Clock::duration, 3> spent{};  // time in each class, before `since`
  bool away = false;
  Clock::time_point paused_since{}, works_until{}, used_at{};
  Clock::duration paused_for{};
  double used_by_now = 0;  ///< processor seconds charged so far
  StopToken stop_token{};
  std::optional<Clock::time_point> deadline{};
  // Only the job's own thread uses these.
  double elsewhere = 0;  ///< processor seconds in other processes
  double charged = 0;    ///< clock reading at the last charge(): seconds of the thread and elsewhere
  Clock::time_point next_tick{};

  static thread_local Running* of_this_thread;

 private:
  /// kTick: time between two readings of the processor clock. kLook: how often a job that stands still checks whether it is
  /// still wanted.
  static constexpr std::chrono::milliseconds kTick{4}, kLook{25};

  bool concerns_it() const {
    return asked.load(std::memory_order_relaxed) || paused.load(std::memory_order_relaxed) ||
           must_end.load(std::memory_order_relaxed);
  }
  bool unwanted() const { return stop_token.stop_requested() || (deadline && Clock::now() > *deadline); }
  Priority priority_of_charge() const {
    const std::lock_guard lock(pool.mutex_);
    return priority;
  }
  void tick() {
    const Clock::time_point now = Clock::now();
    if (now < next_tick) return;
    charge();
    const std::lock_guard lock(pool.mutex_);
    pool.schedule();
    next_tick = now + kTick;
  }
  void set_away(bool is_away) {
    const std::lock_guard lock(pool.mutex_);
    away = is_away;
    pool.schedule();
  }
  void end_if_too_many() const {
    if (must_end)
      throw Interrupted(Error{
          .code = ErrorCode::kOverloaded,
          .detail = "This computation was stopped because more urgent computations need its thread or its "
                    "memory. Send the request again.",
          .retry_after = std::chrono::seconds(1)});
  }
};

}  // namespace fracture
