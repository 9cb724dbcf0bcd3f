// What the pool says of itself: how much waits, how long a new task would, and what it learns that from.
#include <algorithm>

#include "common/base/bulk.hpp"
#include "server/service/worker_pool.hpp"
#include "server/service/worker_pool_running.hpp"

namespace fracture {

std::vector<std::optional<std::size_t>> WorkerPool::positions(const std::vector<TaskId>& tasks) const {
  std::vector<std::optional<std::size_t>> positions(tasks.size());
  const std::lock_guard lock(mutex_);
  const std::size_t queued = queued_locked();
  if (queued > kMostPlaced) return positions;
  constexpr std::size_t kAsHashed = 16;  // bytes: two passes over a task take as long as hashing so many
  count_bulk(kAsHashed * queued);
  std::size_t before = 0;
  for (const Class& waits : classes_) before += waits.resumed.size();
  for (const Class& waits : classes_) {
    const auto places = waits.queue.places(tasks);
    for (std::size_t k = 0; k < tasks.size(); ++k)
      if (places[k]) positions[k] = before + *places[k];
    before += waits.queue.size();
  }
  return positions;
}

bool WorkerPool::full(Priority priority, const Flow& flow) const {
  const std::lock_guard lock(mutex_);
  std::size_t waiting = 0, own = 0, busy = 0, ahead = 0;
  for (const Priority counted : kPriorities) {
    if (counted <= priority) ahead += running_of(counted);
    if ((counted == Priority::kBackground) != (priority == Priority::kBackground)) continue;
    const FairQueue<Task>& queue = of(counted).queue;
    waiting += queue.size();
    own += queue.size_of(flow.name);
    busy += queue.busy_flows();
  }
  // An idle worker, or one that stands back, takes the job at once: such a job does not count as queued.
  const std::size_t idle = thread_count_ - std::min(thread_count_, ahead);
  if (waiting < max_queue_ + idle) return false;
  // Each further flow has a place for its first task, and addresses are many.
  if (waiting >= 2 * max_queue_ + idle) return true;
  const std::size_t others = busy - (own > 0 ? 1 : 0);
  // Who fills the queue leaves the others their part of it.
  return max_queue_ == 0 || own >= std::max<std::size_t>(1, max_queue_ / (others + 1));
}

std::chrono::duration<double> WorkerPool::predicted_wait(Priority priority, const Flow& flow) const {
  const std::lock_guard lock(mutex_);
  std::size_t tasks = 0;
  double ahead = 0;
  for (const Priority before : kPriorities) {
    if (before > priority) continue;  // those stand back
    const Class& queued = of(before);
    tasks += queued.resumed.size() + queued.queue.size() + running_of(before);
    ahead += before < priority ? queued.queue.cost() : queued.queue.ahead_of(flow);
    for (const Task& goes_on : queued.resumed) ahead += goes_on.cost;
  }
  if (tasks < thread_count_) return {};
  ahead *= took_ / cost_;
  const Clock::time_point now = Clock::now();
  for (const auto& [id, job] : running_) {
    if (job->priority > priority) continue;
    Clock::duration computed = now - job->start - job->paused_for;
    if (job->paused) computed -= now - job->paused_since;
    ahead += std::max(0.0, job->cost * took_ / cost_ - Seconds(computed).count());
  }
  return Seconds(ahead / static_cast<double>(thread_count_));
}

std::chrono::duration<double> WorkerPool::predicted_run(double cost) const {
  const std::lock_guard lock(mutex_);
  return Seconds(cost * took_ / cost_);
}

void WorkerPool::measured(double cost, double seconds) {
  constexpr double kKept = 0.95;  // the last twenty or so decide
  const std::lock_guard lock(mutex_);
  took_ = kKept * took_ + seconds;
  cost_ = kKept * cost_ + cost;
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard lock(mutex_);
  return queued_locked();
}

std::size_t WorkerPool::running() const {
  const std::lock_guard lock(mutex_);
  return running_.size();
}

std::size_t WorkerPool::paused() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::count_if(running_.begin(), running_.end(),
                                                [](const auto& job) { return job.second->paused.load(); }));
}

}  // namespace fracture
