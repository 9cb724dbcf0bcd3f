#include "server/service/worker_pool.hpp"

#include <algorithm>
#include <utility>

#include "server/service/worker_pool_running.hpp"

namespace fracture {

thread_local WorkerPool::Running* WorkerPool::Running::of_this_thread = nullptr;

Turn* WorkerPool::turn() { return Running::of_this_thread; }

double WorkerPool::paused_seconds() {
  const Running* const mine = Running::of_this_thread;
  if (!mine) return 0;
  const std::lock_guard lock(mine->pool.mutex_);
  return Seconds(mine->paused_for).count();
}

double WorkerPool::seconds_elsewhere() {
  const Running* const mine = Running::of_this_thread;
  return mine ? mine->elsewhere : 0;
}

WorkerPool::WorkerPool(int threads, std::size_t max_queue, const Longest& longest)
    : max_queue_(max_queue),
      longest_{longest.realtime, longest.batch},
      thread_count_(static_cast<std::size_t>(std::max(1, threads))) {
  // As many for each class, whose jobs stand still for those of the others: as many jobs compute at the same
  // time as was asked for.
  threads_.reserve(most_running());
  for (std::size_t t = 0; t < most_running(); ++t) threads_.emplace_back([this] { work(); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  go_on_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

WorkerPool::TaskId WorkerPool::submit(Priority priority, double cost, Job job, const Flow& flow) {
  const std::lock_guard lock(mutex_);
  const TaskId id = next_++;
  of(priority).queue.push({id, cost, flow, Clock::now(), std::move(job), priority});
  changed();
  return id;
}

WorkerPool::TaskId WorkerPool::resume(Job job, Priority priority, double cost,
                                      std::optional<Priority> origin) {
  const std::lock_guard lock(mutex_);
  const TaskId id = next_++;
  of(priority).resumed.push_back({id, cost, {}, Clock::now(), std::move(job), origin.value_or(priority)});
  changed();
  return id;
}

bool WorkerPool::reclassify(TaskId task, Priority priority, const Flow& flow) {
  const std::lock_guard lock(mutex_);
  if (const auto at = running_.find(task); at != running_.end()) {
    become(*at->second, priority);
    changed();
    return false;
  }
  bool is_queued = false;
  for (const Priority before : kPriorities) {
    if (before == priority) continue;
    std::deque<Task>& resumed = of(before).resumed;
    const auto waiting =
        std::find_if(resumed.begin(), resumed.end(), [&](const Task& waits) { return waits.id == task; });
    if (waiting != resumed.end()) {
      of(priority).resumed.push_back(std::move(*waiting));
      resumed.erase(waiting);
    } else if (std::optional<Task> queued = of(before).queue.remove(task)) {
      queued->flow = flow;
      of(priority).queue.push(std::move(*queued));
      is_queued = true;
    }
  }
  changed();
  return is_queued;
}

bool WorkerPool::withdraw(TaskId task) {
  std::unique_lock lock(mutex_);
  std::optional<Task> withdrawn;
  for (const Priority priority : kPriorities)
    if (!withdrawn) withdrawn = of(priority).queue.remove(task);
  if (!withdrawn) return false;
  ++withdrawing_;
  lock.unlock();
  withdrawn.reset();  // what it holds is released before anybody is told that nothing is left
  lock.lock();
  --withdrawing_;
  rest();
  return true;
}

void WorkerPool::charge(Priority priority, const Flow& flow, double seconds) {
  const std::lock_guard lock(mutex_);
  of(priority).queue.charge(flow, seconds);
}

void WorkerPool::revise(TaskId task, double cost) {
  const std::lock_guard lock(mutex_);
  if (const auto at = running_.find(task); at != running_.end()) at->second->cost = cost;
}

void WorkerPool::wait_idle() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return is_idle(); });
}

std::size_t WorkerPool::queued_locked() const {
  std::size_t queued = 0;
  for (const Class& waits : classes_) queued += waits.resumed.size() + waits.queue.size();
  return queued;
}

std::size_t WorkerPool::running_of(Priority priority) const {
  return static_cast<std::size_t>(std::count_if(
      running_.begin(), running_.end(), [&](const auto& job) { return job.second->priority == priority; }));
}

std::size_t WorkerPool::places_of(Priority priority) const {
  return static_cast<std::size_t>(std::count_if(running_.begin(), running_.end(), [&](const auto& job) {
    return job.second->priority == priority ||
           (job.second->began == priority && job.second->priority < priority);
  }));
}

std::size_t WorkerPool::computing(Priority least) const {
  return static_cast<std::size_t>(std::count_if(running_.begin(), running_.end(), [&](const auto& job) {
    return job.second->computes() && job.second->priority <= least;
  }));
}

bool WorkerPool::any_paused(Priority least) const {
  return std::any_of(running_.begin(), running_.end(),
                     [&](const auto& job) { return job.second->paused && job.second->priority <= least; });
}

bool WorkerPool::has_thread(Priority priority) const {
  if (priority == Priority::kRealtime) return running_.size() < most_running();
  return running_.size() < most_running() - thread_count_ && places_of(priority) < thread_count_;
}

bool WorkerPool::may_begin(Priority priority) const {
  if (!has_thread(priority)) return false;
  const std::size_t now = computing();
  if (priority == Priority::kRealtime)
    return now < thread_count_ || (now == thread_count_ && thread_count_ > 1 && running_of(priority) == 0);
  return now < thread_count_ && !any_paused(priority);  // who stands still goes on before others begin
}

bool WorkerPool::must_stand_back(Priority priority) const {
  if (computing(priority) > thread_count_) return true;
  if (computing() < thread_count_) return false;
  for (const Priority urgent : kPriorities) {
    if (urgent >= priority) break;
    if (any_paused(urgent) || (of(urgent).waits() && has_thread(urgent) && !may_begin(urgent))) return true;
  }
  return false;
}

bool WorkerPool::may_go_on(Priority priority) const {
  if (computing() >= thread_count_) return false;
  for (const Priority urgent : kPriorities) {
    if (urgent >= priority) break;
    if (any_paused(urgent) || (of(urgent).waits() && may_begin(urgent))) return false;
  }
  return true;
}

std::optional<WorkerPool::Next> WorkerPool::next() const {
  std::optional<Next> chosen;
  for (const Priority priority : kPriorities) {
    const Class& waiting = of(priority);
    if (!waiting.waits() || !may_begin(priority)) continue;
    const bool aged = chosen && waiting.front().arrival + kAging < of(chosen->priority).front().arrival;
    if (!chosen || aged) chosen = Next{priority, waiting.resumed_is_next()};
  }
  return chosen;
}

WorkerPool::Task WorkerPool::take(Next next) {
  Class& from = of(next.priority);
  from.resumed_was_last = next.resumed;
  if (!next.resumed) return from.queue.pop();
  Task task = std::move(from.resumed.front());
  from.resumed.pop_front();
  return task;
}

void WorkerPool::become(Running& job, Priority priority) {
  const Clock::time_point now = Clock::now();
  job.spent[static_cast<std::size_t>(job.priority)] += now - std::exchange(job.since, now);
  for (const Priority spent : {Priority::kRealtime, Priority::kBatch})
    if (priority == spent &&
        job.spent[static_cast<std::size_t>(spent)] >= longest_[static_cast<std::size_t>(spent)])
      priority = kPriorities[static_cast<std::size_t>(spent) + 1];
  const Priority before = std::exchange(job.priority, priority);
  if (before == priority) return;
  if (priority > before) thin_out();
  go_on_.notify_all();
}

void WorkerPool::thin_out() {
  for (const Priority least : {Priority::kBackground, Priority::kBatch}) {
    const std::size_t most = least == Priority::kBatch ? 2 * thread_count_ : thread_count_;
    const auto counts = [least](const Running& job) { return job.priority >= least && !job.must_end; };
    auto count = static_cast<std::size_t>(std::count_if(
        running_.begin(), running_.end(), [&](const auto& job) { return counts(*job.second); }));
    // The latest first. Of the others no more begin than may run.
    for (auto job = running_.rbegin(); count > most && job != running_.rend(); ++job) {
      if (!counts(*job->second) || job->second->began >= least) continue;
      job->second->must_end = true;
      --count;
    }
  }
}

void WorkerPool::end_classes() {
  const Clock::time_point now = Clock::now();
  Clock::time_point next = Clock::time_point::max();
  for (const auto& [id, job] : running_) {
    if (job->class_ends() <= now) become(*job, job->priority);
    next = std::min(next, job->class_ends());
  }
  const bool somebody_waits = queued_locked() > 0 || any_paused(Priority::kBackground);
  class_ends_ = somebody_waits ? next.time_since_epoch().count() : kNever;
}

bool WorkerPool::some_class_ended() const {
  const Clock::rep end = class_ends_.load(std::memory_order_relaxed);
  return end != kNever && Clock::now().time_since_epoch().count() >= end;
}

/// Tells whom a change concerns.
void WorkerPool::changed() {
  end_classes();
  const auto some_must = [this](Priority priority) {
    const auto computes = [priority](const auto& job) {
      return job.second->priority == priority && job.second->computes();
    };
    return std::any_of(running_.begin(), running_.end(), computes) && must_stand_back(priority);
  };
  urgent_ = some_must(Priority::kBatch) || some_must(Priority::kBackground);
  if (next()) wake_.notify_one();
  if (computing() < thread_count_) go_on_.notify_all();
}

void WorkerPool::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    std::optional<Next> chosen;
    wake_.wait(lock, [&] { return (chosen = next()) || (stopping_ && queued_locked() == 0); });
    if (!chosen) return;
    Task task = take(*chosen);
    // Where it was hurried and there is a place where it comes from, it is that which it keeps.
    const bool has_its_place = task.origin > chosen->priority && has_thread(task.origin);
    Running job(*this, chosen->priority, task.cost, has_its_place ? task.origin : chosen->priority);
    running_[task.id] = &job;
    std::size_t sharing = computing(chosen->priority);
    for (const Priority priority : kPriorities)  // those that are less urgent stand back
      if (priority <= chosen->priority) sharing += of(priority).resumed.size() + of(priority).queue.size();
    sharing = std::clamp<std::size_t>(sharing, 1, thread_count_);
    changed();
    lock.unlock();

    Running::of_this_thread = &job;
    try {
      task.job(static_cast<int>(thread_count_ / sharing));
    } catch (...) {  // a bug, or no memory even to say that there is none: the others go on
      ++escaped_;
    }
    task.job = nullptr;  // what it holds (a request body) is released here, not when the next job arrives
    Running::of_this_thread = nullptr;

    lock.lock();
    running_.erase(task.id);
    rest();
  }
}

/// A task has ended, one way or another.
void WorkerPool::rest() {
  const std::size_t most = 2 * max_queue_ + thread_count_;  // flows of one class that are remembered
  for (const Priority priority : kPriorities) {
    Class& served = of(priority);
    if (!served.waits() && running_of(priority) == 0)
      served.queue.idle();
    else if (served.queue.flows() > most)
      served.queue.sweep(most);
  }
  if (is_idle()) {
    idle_.notify_all();
    if (stopping_) wake_.notify_all();
  }
  changed();
}

}  // namespace fracture
