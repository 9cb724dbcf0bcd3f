// The classes of running tasks: how long a task keeps its class, and which tasks end because more urgent ones need their
// threads.
#include <algorithm>
#include <cstddef>
#include <utility>

#include "server/service/worker_pool.hpp"
#include "server/service/worker_pool_running.hpp"

namespace fracture {

void WorkerPool::become(Running& job, Priority priority) {
  const Clock::time_point now = Clock::now();
  job.spent[static_cast<std::size_t>(job.priority)] += now - std::exchange(job.since, now);
  for (const Priority spent : {Priority::kRealtime, Priority::kBatch})
    if (priority == spent &&
        job.spent[static_cast<std::size_t>(spent)] >= longest_[static_cast<std::size_t>(spent)])
      priority = kPriorities[static_cast<std::size_t>(spent) + 1];
  const Priority before = std::exchange(job.priority, priority);
  if (priority > before) thin_out();
}

void WorkerPool::thin_out() {
  for (const Priority least : {Priority::kBackground, Priority::kBatch}) {
    const std::size_t most = least == Priority::kBatch ? 2 * thread_count_ : thread_count_;
    const auto counts = [least](const Running& job) { return job.priority >= least && !job.must_end; };
    const auto count_of = [&](const Client& client) {
      return static_cast<std::size_t>(std::count_if(running_.begin(), running_.end(), [&](const auto& job) {
        return &job.second->client == &client && counts(*job.second);
      }));
    };
    // The latest tasks end first. Tasks that began in these classes never exceed the limit on their own.
    for (auto at = running_.rbegin(); at != running_.rend(); ++at) {
      Running& job = *at->second;
      if (!counts(job) || job.began >= least || count_of(job.client) <= most) continue;
      job.must_end = true;
      job.go_on.notify_all();
    }
  }
}

void WorkerPool::end_classes() {
  if (queue_.empty() && !any_paused()) return;  // no task waits
  const Clock::time_point now = Clock::now();
  for (const auto& [id, job] : running_)
    if (job->class_ends() <= now) become(*job, job->priority);
}

bool WorkerPool::give_up(TaskId task, Priority most) {
  const std::lock_guard lock(mutex_);
  const auto at = running_.find(task);
  if (at == running_.end() || at->second->priority < most) return false;
  at->second->must_end = true;
  at->second->go_on.notify_all();
  return true;
}

}  // namespace fracture
