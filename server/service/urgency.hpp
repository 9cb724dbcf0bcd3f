// The urgency of a computation: that of the most urgent client that is waiting for it now.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "server/service/payer.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture {

/// The urgency of one flight. Thread-safe. A result needs parts (a mesh and a diagram), which are flights of their own. It
/// waits for a part like a client, as urgently as its own clients wait for the result. Locks are taken in this order:
/// result, part, pool.
class Urgency {
 public:
  /// Adds the leader, which waits like the others, and calls `submit` to queue the computing task at the leader's turn.
  /// Followers may have joined before and may be more urgent; then the task takes their class and turn.
  template <class Submit>
  void lead(WorkerPool& pool, const Flow& flow, Priority priority, Submit submit) {
    const std::lock_guard lock(mutex_);
    add(priority, flow);
    priority_ = priority;
    task_ = submit();
    decide(pool);
    hasten(pool, priority_, Flow(this->flow()));
  }

  /// Adds a client that waits. If the task is queued and this client's turn comes sooner, the task takes this turn. So one
  /// client's long queue does not delay others that ask for the same value.
  void join(WorkerPool& pool, Priority priority, const Flow& flow) {
    const std::lock_guard lock(mutex_);
    add_to(pool, priority, flow);
  }
  /// Removes a client, follower or leader, that no longer waits.
  void leave(WorkerPool& pool, Priority priority) {
    const std::lock_guard lock(mutex_);
    --waiting(priority);
    decide(pool);
  }

  /// The computation waits for a part that another one computes. Does nothing if that part is already over: the task may
  /// have gone on by now, and may be waiting for its next part.
  void waits_for(WorkerPool& pool, std::shared_ptr<Urgency> part) {
    const std::lock_guard lock(mutex_);
    if (part->join_unless_over(pool, priority_, flow())) part_ = std::move(part);
  }
  /// The part has landed. `resume` queues the task that continues the computation.
  template <class Resume>
  void goes_on(WorkerPool& pool, Resume resume) {
    const std::lock_guard lock(mutex_);
    part_ = nullptr;
    task_ = resume(priority_, flow());
    tell_of_others(pool);
  }

  /// The computation's own task computes the part. Until end_part(), the part decides how urgent the task is, because others
  /// may also wait for the part.
  void lead_part(WorkerPool& pool, std::shared_ptr<Urgency> part) {
    const std::lock_guard lock(mutex_);
    part->lead(pool, flow(), priority_, [this] { return task_; });
    part_ = std::move(part);
    in_part_ = true;
  }
  /// Ends the part. From now on, the task is as urgent as the clients that wait for the result.
  void end_part(WorkerPool& pool, Urgency& part) {
    const std::lock_guard lock(mutex_);
    part.end();
    part_ = nullptr;
    in_part_ = false;
    pool.reclassify(task_, priority_, flow());
  }
  /// The value is computed and about to land. Clients that still join do not hurry anything.
  void end() {
    const std::lock_guard lock(mutex_);
    task_ = 0;
    over_ = true;
  }
  /// Nobody waits for the result any more, so it stops waiting for its part.
  void gives_up(WorkerPool& pool) {
    const std::lock_guard lock(mutex_);
    if (part_) part_->leave(pool, priority_);
    part_ = nullptr;
  }

  Priority priority() const {
    const std::lock_guard lock(mutex_);
    return priority_;
  }
  /// Returns the priority of the task. While the task computes a part, it is the part's priority, because others may wait
  /// for that part.
  Priority priority_of_task() const {
    const std::lock_guard lock(mutex_);
    return computes_part() ? part_->priority() : priority_;
  }
  /// Returns whether more than one client is waiting or has waited.
  bool is_of_several() const {
    const std::lock_guard lock(mutex_);
    return others_;
  }
  /// Returns whether the task computes a part of an answer that other clients also wait for.
  bool computes_for_others() const {
    const std::lock_guard lock(mutex_);
    return computes_part() && part_->is_of_several();
  }
  /// Returns whether the task stands still for at least a second, because its only client exceeds its processor rate.
  bool stands_still() const {
    constexpr std::chrono::seconds kLong{1};
    const std::lock_guard lock(mutex_);
    return !others_ && !(computes_part() && part_->is_of_several()) && flow().account &&
           flow().account->until_within_processor_rate() >= kLong;
  }
  /// Returns the turn that the task takes: the earliest turn among the most urgent clients that wait.
  Flow turn() const {
    const std::lock_guard lock(mutex_);
    return flow();
  }
  /// Returns the task's id. The task may call this itself, because it may run before submit() or resume() returns its id.
  WorkerPool::TaskId task() const {
    const std::lock_guard lock(mutex_);
    return task_;
  }

 private:
  /// Returns whether its task computes a part that it has not given up. Requires the lock.
  bool computes_part() const { return in_part_ && part_; }
  struct Waiting {
    std::size_t count = 0;
    Flow flow{};  ///< the earliest turn; the client that had it may have left
  };

  // All functions from here on require the lock.
  std::size_t& waiting(Priority priority) { return waiting_[static_cast<std::size_t>(priority)].count; }
  const Flow& flow() const { return waiting_[static_cast<std::size_t>(priority_)].flow; }
  void add(Priority priority, const Flow& flow) {
    if (waiting(priority) == 0) waiting_[static_cast<std::size_t>(priority)].flow = flow;
    ++waiting(priority);
    if (!first_) first_ = flow.name;
    others_ = others_ || flow.name != *first_;
  }
  void add_to(WorkerPool& pool, Priority priority, const Flow& flow) {
    add(priority, flow);
    decide(pool);
    hasten(pool, priority, flow);
  }
  /// Lets the task take this turn if the task is queued and the turn comes sooner. Does the same for a part that it waits for.
  void hasten(WorkerPool& pool, Priority priority, const Flow& flow) {
    if (priority != priority_ || in_part_) return;
    Flow& turn = waiting_[static_cast<std::size_t>(priority)].flow;
    if (task_ > 0 && pool.hasten(task_, flow)) turn = flow;
    if (!part_) return;
    const std::lock_guard lock(part_->mutex_);
    part_->hasten(pool, priority, flow);
  }
  /// Tells the pool if several clients wait. Then the task runs even if its first client is over its processor rate.
  void tell_of_others(WorkerPool& pool) {
    if (others_ && task_ > 0) pool.share(task_);
  }
  /// Updates the task after the waiting clients have changed. If nobody waits any more, the task is being stopped and keeps
  /// its class. Its remaining cost becomes 0, because predictions must not count it.
  void decide(WorkerPool& pool) {
    tell_of_others(pool);
    const Priority before = priority_;
    std::size_t most_urgent = 0;
    while (most_urgent < waiting_.size() && waiting_[most_urgent].count == 0) ++most_urgent;
    if (most_urgent == waiting_.size() && !in_part_) pool.revise(task_, 0);
    if (most_urgent == waiting_.size() || static_cast<Priority>(most_urgent) == before) return;
    priority_ = static_cast<Priority>(most_urgent);
    if (part_) part_->move(pool, before, priority_, flow());
    if (in_part_) return;
    pool.reclassify(task_, priority_, flow());
  }

  void move(WorkerPool& pool, Priority from, Priority to, const Flow& flow) {
    const std::lock_guard lock(mutex_);
    --waiting(from);
    add_to(pool, to, flow);
  }
  bool join_unless_over(WorkerPool& pool, Priority priority, const Flow& flow) {
    const std::lock_guard lock(mutex_);
    if (over_) return false;
    add_to(pool, priority, flow);
    return true;
  }

  mutable std::mutex mutex_;
  std::array<Waiting, 3> waiting_;  ///< by Priority
  Priority priority_ = Priority::kBackground;
  WorkerPool::TaskId task_ = 0;       ///< 0: no task that could be hurried
  std::optional<std::string> first_;  ///< name of the first client
  bool others_ = false;               ///< clients with other names have also joined
  std::shared_ptr<Urgency> part_;     ///< the part that it waits for or computes
  bool in_part_ = false;              ///< its own task computes the part
  bool over_ = false;
};

}  // namespace fracture
