// How urgent a computation is: as urgent as the most urgent of all who wait for it, now.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "server/service/payer.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture {

/// Of one flight. Thread-safe. A result that needs a part (a mesh or a diagram, a flight of its own) waits for it
/// like a client, as urgently as its own clients wait for the result. Locks are taken in this order: of the
/// result, of the part, of the pool.
class Urgency {
 public:
  /// The leader, who waits like the others, queues the task that computes, at the turn it takes. Who joined
  /// before may be more urgent.
  template <class Submit>
  void lead(WorkerPool& pool, const Flow& flow, Priority priority, Submit submit) {
    const std::lock_guard lock(mutex_);
    add(priority, flow);
    priority_ = priority;
    task_ = submit();
    decide(pool);
    hasten(pool, priority_, Flow(this->flow()));
  }

  /// One more waits. A task that is queued takes its turn, if that comes sooner than the turn of those who wait already: one
  /// client's queue does not keep others waiting who ask for the same.
  void join(WorkerPool& pool, Priority priority, const Flow& flow) {
    const std::lock_guard lock(mutex_);
    add_to(pool, priority, flow);
  }
  /// One who joined, or the leader, waits no longer.
  void leave(WorkerPool& pool, Priority priority) {
    const std::lock_guard lock(mutex_);
    --waiting(priority);
    decide(pool);
  }

  /// It waits for a part that others compute. Where that is over by then, this changes nothing: the task may have
  /// gone on already, and wait for its next part.
  void waits_for(WorkerPool& pool, std::shared_ptr<Urgency> part) {
    const std::lock_guard lock(mutex_);
    if (part->join_unless_over(pool, priority_, flow())) part_ = std::move(part);
  }
  /// The part has landed. `resume` queues the task as which it goes on.
  template <class Resume>
  void goes_on(WorkerPool& pool, Resume resume) {
    const std::lock_guard lock(mutex_);
    part_ = nullptr;
    task_ = resume(priority_, flow());
    tell_of_others(pool);
  }

  /// Its own task computes the part: until end_part() that decides how urgent the task is, for others wait for
  /// the part as well.
  void lead_part(WorkerPool& pool, std::shared_ptr<Urgency> part) {
    const std::lock_guard lock(mutex_);
    part->lead(pool, flow(), priority_, [this] { return task_; });
    part_ = std::move(part);
    in_part_ = true;
  }
  /// The part ends; the task is as urgent as those who wait for the result.
  void end_part(WorkerPool& pool, Urgency& part) {
    const std::lock_guard lock(mutex_);
    part.end();
    part_ = nullptr;
    in_part_ = false;
    pool.reclassify(task_, priority_, flow());
  }
  /// It is computed, and lands next: who still joins hurries nobody.
  void end() {
    const std::lock_guard lock(mutex_);
    task_ = 0;
    over_ = true;
  }
  /// Nobody waits for the result any more, and so the result not for its part.
  void gives_up(WorkerPool& pool) {
    const std::lock_guard lock(mutex_);
    if (part_) part_->leave(pool, priority_);
    part_ = nullptr;
  }

  Priority priority() const {
    const std::lock_guard lock(mutex_);
    return priority_;
  }
  /// The priority of its task. If the task computes a part, others may wait for that part.
  Priority priority_of_task() const {
    const std::lock_guard lock(mutex_);
    return in_part_ ? part_->priority() : priority_;
  }
  /// More than one client waits, or has waited.
  bool is_of_several() const {
    const std::lock_guard lock(mutex_);
    return others_;
  }
  /// Whose turn it takes: the earliest of the most urgent who wait.
  Flow turn() const {
    const std::lock_guard lock(mutex_);
    return flow();
  }
  /// The task may ask itself: it runs, perhaps, before submit() or resume() has said which it is.
  WorkerPool::TaskId task() const {
    const std::lock_guard lock(mutex_);
    return task_;
  }

 private:
  struct Waiting {
    std::size_t count = 0;
    Flow flow{};  ///< of the one whose turn came first, whether that still waits or not
  };

  // All of these with the lock.
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
  /// The task, or the part that it waits for, is queued and may take this turn.
  void hasten(WorkerPool& pool, Priority priority, const Flow& flow) {
    if (priority != priority_ || in_part_) return;
    Flow& turn = waiting_[static_cast<std::size_t>(priority)].flow;
    if (task_ > 0 && pool.hasten(task_, flow)) turn = flow;
    if (!part_) return;
    const std::lock_guard lock(part_->mutex_);
    part_->hasten(pool, priority, flow);
  }
  /// That its first client is over its rate must not keep the others waiting.
  void tell_of_others(WorkerPool& pool) {
    if (others_ && task_ > 0) pool.share(task_);
  }
  /// Those who wait have changed. When nobody does, it is being stopped, and ends in the class that it has: it is not what
  /// others would have to wait for.
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
  WorkerPool::TaskId task_ = 0;       ///< 0: none that could be hurried
  std::optional<std::string> first_;  ///< whose name came first ...
  bool others_ = false;               ///< ... and whether another one did
  std::shared_ptr<Urgency> part_;     ///< what it waits for, or computes as a part
  bool in_part_ = false;              ///< it computes that itself
  bool over_ = false;
};

}  // namespace fracture
