// The pool's statistics and predictions: how much work waits, how long a new task would wait, and the measurements behind
// these predictions.
#include <algorithm>
#include <utility>

#include "common/base/bulk.hpp"
#include "server/service/fair_share.hpp"
#include "server/service/worker_pool.hpp"
#include "server/service/worker_pool_running.hpp"

namespace fracture {

std::vector<std::optional<std::size_t>> WorkerPool::positions(const std::vector<TaskId>& tasks) const {
  std::vector<std::optional<std::size_t>> positions(tasks.size());
  const std::lock_guard lock(mutex_);
  const std::size_t queued = queue_.size();
  if (queued > kMostPlaced) return positions;
  constexpr std::size_t kAsHashed =
      64;  // bytes: finding a task's position takes as long as hashing this many
  count_bulk(kAsHashed * queued);
  std::vector<std::pair<TaskId, std::size_t>> asked;
  for (std::size_t k = 0; k < tasks.size(); ++k) asked.emplace_back(tasks[k], k);
  std::sort(asked.begin(), asked.end());
  std::size_t before = 0;
  for (const Priority priority : kPriorities) before += queue_.resumed(priority);
  for (const TaskId id : queue_.order()) {
    auto at = std::lower_bound(asked.begin(), asked.end(), std::pair(id, std::size_t{0}));
    for (; at != asked.end() && at->first == id; ++at) positions[at->second] = before;
    ++before;
  }
  return positions;
}

bool WorkerPool::full(Priority priority, const Flow& flow) const {
  const std::lock_guard lock(mutex_);
  std::size_t waiting = 0, own = 0, others = 0, ahead = 0;
  for (const Priority counted : kPriorities) {
    if (counted <= priority) ahead += running_of(counted);
    if ((counted == Priority::kBackground) != (priority == Priority::kBackground)) continue;
    waiting += queue_.size(counted);
    own += queue_.size_of(flow.name, counted);
    others += queue_.others_than(flow.name, counted);
  }
  // A job does not count as queued if an idle thread, or one whose job can stand back, takes it at once.
  const std::size_t idle = thread_count_ - std::min(thread_count_, ahead);
  if (waiting < idle) return false;
  waiting -= idle;
  if (own == 0) return waiting >= 4 * max_queue_;  // a flow's first task, even if the others use all theirs
  own -= std::min(own, idle);
  return !FairShare{2 * max_queue_, max_queue_}.allows(own + 1, waiting + 1, others, false);
}

bool WorkerPool::has_idle_processors(Priority priority) const {
  std::size_t tasks = 0;
  for (const Priority before : kPriorities)
    if (before <= priority) tasks += queue_.resumed(before) + queue_.size(before) + running_of(before);
  return tasks < thread_count_;
}

double WorkerPool::left_of(const Client& client, Priority priority) const {
  const Clock::time_point now = Clock::now();
  const double pace = pace_.of(client.name);
  double seconds = pace * client.line(priority).cost();
  for (const auto& [id, job] : running_) {
    if (&job->client != &client || job->priority != priority) continue;
    const Clock::duration computed = now - job->start - job->paused_for - job->stood(now);
    seconds += std::max(0.0, job->task.cost * pace - Seconds(computed).count());
  }
  return seconds;
}

std::chrono::duration<double> WorkerPool::predicted_wait(Priority priority, const Flow& flow,
                                                         double cost) const {
  const std::lock_guard lock(mutex_);
  if (has_idle_processors(priority)) return {};
  const auto left = [this](const Client& client, Priority of) { return left_of(client, of); };
  return Seconds(queue_.ahead_of(priority, flow, cost * pace_.of(flow.name), left) /
                 static_cast<double>(thread_count_));
}

std::chrono::duration<double> WorkerPool::backlog(Priority priority) const {
  const std::lock_guard lock(mutex_);
  if (has_idle_processors(priority)) return {};
  const auto left = [this](const Client& client, Priority of) { return left_of(client, of); };
  return Seconds(queue_.left(priority, left) / static_cast<double>(thread_count_));
}

std::chrono::duration<double> WorkerPool::predicted_run(const std::string& client, double cost) const {
  const std::lock_guard lock(mutex_);
  return Seconds(cost * pace_.of(client));
}

void WorkerPool::measured(const std::string& client, double cost, double seconds) {
  const std::lock_guard lock(mutex_);
  pace_.measured(client, cost, seconds);
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
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
