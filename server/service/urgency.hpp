// How urgent a computation is: as urgent as the most urgent of all who wait for it.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/payer.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture {

/// Of one flight. Thread-safe. Locks of other flights are taken within its own only through waits_for(): from a
/// result to the mesh or diagram that it waits for.
class Urgency {
 public:
  using Raise = std::function<void(Priority, const Flow&)>;

  /// The leader queues the task that computes, at the turn it takes. Who joined before may be more urgent.
  template <class Submit>
  void lead(WorkerPool& pool, const TurnTaken& turn, Submit submit) {
    const std::lock_guard lock(mutex_);
    turn_ = turn;
    const bool hurried = priority_ < turn.priority;
    if (!hurried) priority_ = turn.priority;
    task_ = submit();
    if (hurried) promote(pool);
  }

  /// Computed as part of a task that runs for somebody else; end_part() ends that.
  void lead_part(WorkerPool& pool, WorkerPool::TaskId task, Priority own) {
    const std::lock_guard lock(mutex_);
    const bool hurried = priority_ < own;
    if (!hurried) priority_ = own;
    task_ = task;
    if (hurried) promote(pool);
  }
  void end_part() {
    const std::lock_guard lock(mutex_);
    task_ = 0;  // who still joins hurries nobody
  }
  /// The task is as urgent as those who wait for it again, and no longer as those who waited for a part.
  void restore(WorkerPool& pool) {
    const std::lock_guard lock(mutex_);
    pool.reclassify(task_, priority_);
  }

  /// One more waits. Its flow gives the turn, where that has not come yet.
  void join(WorkerPool& pool, Priority priority, const Flow& flow) {
    const std::lock_guard lock(mutex_);
    if (priority >= priority_) return;
    priority_ = priority;
    hurry_ = flow;
    promote(pool);
    if (raise_) raise_(priority, flow);
  }

  /// It waits for something that others compute, told with `raise` of who joins from now on; goes_on() ends that.
  void waits_for(Raise raise) {
    const std::lock_guard lock(mutex_);
    raise(priority_, hurry_.value_or(turn_.flow));
    raise_ = std::move(raise);
  }
  /// `resume` queues the task as which it goes on.
  template <class Resume>
  void goes_on(Resume resume) {
    const std::lock_guard lock(mutex_);
    raise_ = nullptr;
    task_ = resume(priority_.load());
  }

  Priority priority() const { return priority_; }
  /// The task may ask itself: it runs, perhaps, before submit() or resume() has said which it is.
  WorkerPool::TaskId task() const {
    const std::lock_guard lock(mutex_);
    return task_;
  }
  /// What is to be given back when it is known what it has cost.
  TurnTaken turn() const {
    const std::lock_guard lock(mutex_);
    return turn_;
  }

 private:
  void promote(WorkerPool& pool) {
    // Else its turn has come, at the cost of whoever led.
    if (!pool.promote(task_, priority_, *hurry_)) return;
    turn_.flow = *hurry_;
    turn_.priority = priority_;
  }

  mutable std::mutex mutex_;
  std::atomic<Priority> priority_{Priority::kBackground};  ///< of the most urgent who waits
  WorkerPool::TaskId task_ = 0;                            ///< 0: none that could be hurried
  TurnTaken turn_;
  std::optional<Flow> hurry_;  ///< of the first who was so urgent; none where that is the leader
  Raise raise_;                ///< what it waits for is to be hurried
};

}  // namespace fracture
