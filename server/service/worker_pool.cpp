#include "server/service/worker_pool.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "server/service/worker_pool_running.hpp"

namespace fracture {

thread_local WorkerPool::Running* WorkerPool::Running::of_this_thread = nullptr;

Turn* WorkerPool::turn() { return Running::of_this_thread; }

Flow WorkerPool::flow() {
  const Running* const mine = Running::of_this_thread;
  return mine ? mine->task.flow : Flow{};
}

void WorkerPool::charge_by_now() {
  if (Running* const mine = Running::of_this_thread) mine->charge();
}

void WorkerPool::stands_still_while_wanted(const Execution& execution) {
  Running* const mine = Running::of_this_thread;
  if (!mine) return;
  const std::lock_guard lock(mine->pool.mutex_);
  mine->stop_token = execution.stop;
  mine->deadline = execution.deadline;
}

bool WorkerPool::stands_back() {
  const Running* const mine = Running::of_this_thread;
  return mine && (mine->asked || mine->paused);
}

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
  threads_.reserve(kMostThreads);
  for (std::size_t t = 0; t < thread_count_; ++t) {
    threads_.emplace_back([this] { work(); });
    const std::lock_guard lock(mutex_);
    ++free_threads_;
  }
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;  // from now on, no task is held back, and no thread is started
    schedule();
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

WorkerPool::TaskId WorkerPool::submit(Priority priority, double cost, Job job, const Flow& flow, Used used) {
  const std::lock_guard lock(mutex_);
  const TaskId id = next_++;
  queue_.push(priority, {id, cost, flow, Clock::now(), std::move(job), std::move(used), priority});
  schedule();
  return id;
}

WorkerPool::TaskId WorkerPool::resume(Job job, Priority priority, double cost, std::optional<Priority> origin,
                                      const Flow& flow, Used used) {
  const std::lock_guard lock(mutex_);
  const TaskId id = next_++;
  queue_.push_resumed(
      priority, {id, cost, flow, Clock::now(), std::move(job), std::move(used), origin.value_or(priority)});
  schedule();
  return id;
}

bool WorkerPool::reclassify(TaskId task, Priority priority, const Flow& flow) {
  const std::lock_guard lock(mutex_);
  bool is_queued = false;
  if (const auto at = running_.find(task); at != running_.end())
    become(*at->second, priority);
  else
    is_queued = queue_.move(task, priority, flow);
  schedule();
  return is_queued;
}

bool WorkerPool::hasten(TaskId task, const Flow& flow) {
  const std::lock_guard lock(mutex_);
  const bool moved =
      queue_.hasten(task, flow, [this](const Client& client) { return pace_.of(client.name); });
  if (moved) schedule();
  return moved;
}

void WorkerPool::share(TaskId task) {
  const std::lock_guard lock(mutex_);
  if (const auto at = running_.find(task); at != running_.end())
    at->second->task.shared = true;
  else if (Task* const waits = queue_.find(task))
    waits->shared = true;
  schedule();
}

bool WorkerPool::withdraw(TaskId task) { return withdraw(task, &Queue::remove); }

bool WorkerPool::withdraw_resumed(TaskId task) { return withdraw(task, &Queue::remove_resumed); }

bool WorkerPool::withdraw(TaskId task, std::optional<Task> (Queue::*remove)(std::uint64_t id)) {
  std::unique_lock lock(mutex_);
  std::optional<Task> withdrawn = (queue_.*remove)(task);
  if (!withdrawn) return false;
  ++withdrawing_;
  lock.unlock();
  withdrawn.reset();  // releases what it holds before wait_idle() can return
  lock.lock();
  --withdrawing_;
  rest();
  return true;
}

void WorkerPool::charge(Priority priority, const Flow& flow, double seconds) {
  if (flow.account) flow.account->charge(seconds);
  const std::lock_guard lock(mutex_);
  queue_.charge(priority, flow, seconds);
  // A job that computes but uses no processor time (because it waits for a disk, say) must not hold back the lowest tag.
  const Clock::time_point now = Clock::now();
  std::optional<double> least;
  for (const auto& [id, job] : running_)
    if (job->computes() && now - job->used_at < std::chrono::milliseconds(100))
      least = std::min(least.value_or(job->client.tag), job->client.tag);
  if (least) queue_.advance(*least);
  if ((charged_ += seconds) < Seconds(kQuantum).count() / 4) return;
  charged_ = 0;
  schedule();
}

void WorkerPool::revise(TaskId task, double cost) {
  const std::lock_guard lock(mutex_);
  if (const auto at = running_.find(task); at != running_.end()) at->second->task.cost = cost;
}

void WorkerPool::wait_idle() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return is_idle(); });
}

// -- which tasks compute

std::size_t WorkerPool::running_of(Priority priority) const {
  return static_cast<std::size_t>(std::count_if(
      running_.begin(), running_.end(), [&](const auto& job) { return job.second->priority == priority; }));
}

std::size_t WorkerPool::places_of(const Client& client, Priority priority) const {
  return static_cast<std::size_t>(std::count_if(running_.begin(), running_.end(), [&](const auto& job) {
    return &job.second->client == &client &&
           (job.second->priority == priority ||
            (job.second->began == priority && job.second->priority < priority));
  }));
}

std::size_t WorkerPool::computing(Priority least) const {
  return static_cast<std::size_t>(std::count_if(running_.begin(), running_.end(), [&](const auto& job) {
    return job.second->computes() && job.second->priority <= least;
  }));
}

bool WorkerPool::computes(const Client& client) const {
  return std::any_of(running_.begin(), running_.end(), [&](const auto& job) {
    return &job.second->client == &client && job.second->computes();
  });
}

bool WorkerPool::any_paused() const {
  return std::any_of(running_.begin(), running_.end(),
                     [](const auto& job) { return job.second->paused.load(); });
}

bool WorkerPool::has_place(const Client& client, Priority priority) const {
  const std::size_t most = kPriorities.size() * thread_count_;
  if (priority == Priority::kRealtime) return client.running < most;
  return client.running < most - thread_count_ && places_of(client, priority) < thread_count_;
}

bool WorkerPool::is_held(const Flow& flow, bool shared) const {
  return flow.account && !shared && !stopping_ && flow.account->is_over_processor_rate();
}

bool WorkerPool::has_thread() {
  if (free_threads_ > begun_.size()) return true;
  if (stopping_ || threads_.size() >= kMostThreads) return false;
  try {
    threads_.emplace_back([this] { work(); });
  } catch (const std::exception&) {  // the system allows no more threads: the task waits for a free one
    return false;
  }
  ++free_threads_;
  return true;
}

void WorkerPool::schedule() noexcept {
  try {
    decide();
  } catch (const std::bad_alloc&) {  // the rest stays as it is; a free thread tries again soon
    holds_ = true;
    wake_.notify_one();
  }
}

void WorkerPool::decide() {
  end_classes();
  const Clock::time_point now = Clock::now();
  std::vector<Running*> paused;
  for (const auto& [id, job] : running_)
    if (job->paused && !job->is_held()) paused.push_back(job);
  std::sort(paused.begin(), paused.end(), [](const Running* a, const Running* b) {
    return std::pair(a->key(), a->task.id) < std::pair(b->key(), b->task.id);
  });
  holds_ = false;
  const auto may_begin = [this](const Client& client, Priority priority) {
    if (!has_place(client, priority)) return false;
    const Task& task = client.line(priority).front();
    if (!is_held(task.flow, task.shared)) return true;
    holds_ = true;
    return false;
  };
  std::vector<Queue::Next> fresh = queue_.candidates(may_begin);
  for (std::size_t busy = computing(); busy < thread_count_ && !(paused.empty() && fresh.empty()); ++busy) {
    const bool begins =
        !fresh.empty() && (paused.empty() || fresh.front().key() < paused.front()->key()) && has_thread();
    if (begins) {
      begin(fresh.front());
      fresh = queue_.candidates(may_begin);
    } else if (!paused.empty()) {
      paused.front()->start_again();
      paused.erase(paused.begin());
    } else {
      break;  // no thread is available
    }
  }
  // One task more than there are processors may compute: a realtime task if none computes, or a task that has stood still for
  // too long.
  if (computing() == thread_count_) {
    const auto collision = std::find_if(fresh.begin(), fresh.end(), [](const Queue::Next& next) {
      return next.priority == Priority::kRealtime;
    });
    // Only tasks that stand still for their own client count. The others get their turn as other clients use up theirs.
    const auto longest = std::find_if(paused.begin(), paused.end(), [this, now](const Running* job) {
      return job->stood(now) >= kLongestPause && computes(job->client);
    });
    if (thread_count_ > 1 && collision != fresh.end() && computing(Priority::kRealtime) == 0 &&
        has_thread()) {
      begin(*collision);
      fresh = queue_.candidates(may_begin);
    } else if (longest != paused.end()) {
      (*longest)->start_again();
      paused.erase(longest);
    }
  }
  ask(fresh, paused);
  if (holds_ && !watches_) wake_.notify_one();
}

void WorkerPool::begin(const Queue::Next& next) {
  // If the task was hurried and its original class still has a place, it occupies that place.
  const Priority origin = next.item().origin;
  const bool has_its_place = origin > next.priority && has_place(*next.client, origin);
  auto job =
      std::make_unique<Running>(*this, *next.client, next.priority, has_its_place ? origin : next.priority);
  Running& begins = *job;
  begun_.push_back(std::move(job));
  try {
    running_.emplace(next.item().id, &begins);
  } catch (const std::bad_alloc&) {
    begun_.pop_back();
    throw;
  }
  begins.task = queue_.take(next);  // last, so that an exception before leaves the task in the queue
  wake_.notify_one();
}

double WorkerPool::quantum(const Running& job) {
  return Seconds(kQuantum).count() * Queue::cost_of(job.priority);
}

void WorkerPool::ask(const std::vector<Queue::Next>& fresh, const std::vector<Running*>& paused) {
  const Clock::time_point now = Clock::now();
  std::vector<Running*> computing;
  for (const auto& [id, job] : running_) {
    job->asked = job->computes() && job->is_held();
    if (job->computes() && !job->asked && !job->is_protected(now)) computing.push_back(job);
  }
  // The least entitled job comes first. Among jobs of one client and class, the one that began last comes first.
  std::sort(computing.begin(), computing.end(), [](const Running* a, const Running* b) {
    return std::pair(a->key(), a->task.id) > std::pair(b->key(), b->task.id);
  });
  struct Waits {
    const Client* client;
    Priority priority;
  };
  std::vector<Waits> waiting;
  for (const Running* job : paused) waiting.push_back({&job->client, job->priority});
  for (const Queue::Next& next : fresh) waiting.push_back({next.client, next.priority});
  std::sort(waiting.begin(), waiting.end(), [](const Waits& a, const Waits& b) {
    return a.client->key(a.priority) < b.client->key(b.priority);
  });
  const auto goes_before = [](const Waits& waits, const Running& job) {
    if (waits.client == &job.client) return waits.priority < job.priority;
    const bool may_be_stopped = waits.priority < job.priority || job.used_by_now >= Seconds(kShort).count();
    return may_be_stopped && waits.client->key(waits.priority) + quantum(job) < job.key();
  };
  const std::size_t all = this->computing();
  std::size_t too_many = all > thread_count_ ? all - thread_count_ : 0;
  auto first = waiting.begin();
  for (Running* const job : computing) {
    const bool outranked = all >= thread_count_ && first != waiting.end() && goes_before(*first, *job);
    if (too_many == 0 && !outranked) continue;  // a short job may finish; another job may be stopped instead
    job->asked = true;
    if (too_many > 0)
      --too_many;
    else
      ++first;
  }
}

// -- the threads

void WorkerPool::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (begun_.empty() && stopping_ && queue_.empty()) return;
    if (begun_.empty() && holds_ && !watches_) {
      watches_ = true;
      wake_.wait_for(lock, Clock::duration(kQuantum));
      watches_ = false;
      schedule();
      continue;
    }
    if (begun_.empty()) {
      wake_.wait(lock);
      continue;
    }
    const std::unique_ptr<Running> job = std::move(begun_.front());
    begun_.pop_front();
    --free_threads_;
    std::size_t sharing = computing(job->priority);
    for (const Priority priority : kPriorities)  // less urgent tasks do not count, because they stand back
      if (priority <= job->priority) sharing += queue_.resumed(priority) + queue_.size(priority);
    sharing = std::clamp<std::size_t>(sharing, 1, thread_count_);
    lock.unlock();
    run(*job, static_cast<int>(thread_count_ / sharing));
    lock.lock();
    running_.erase(job->task.id);
    queue_.end(job->client);
    ++free_threads_;
    rest();
  }
}

void WorkerPool::run(Running& job, int threads) {
  Running::of_this_thread = &job;
  job.charged = processor_seconds_of_this_thread();
  try {
    job.task.job(threads);
    job.charge();
  } catch (...) {  // a defect, or no memory even to report the lack of memory; other jobs go on
    ++escaped_;
  }
  // Releases what they hold (a request body) now, and not only when the next job arrives.
  job.task.job = nullptr;
  job.task.used = nullptr;
  Running::of_this_thread = nullptr;
}

/// Updates the queue and wakes waiting threads after a task has ended or was withdrawn.
void WorkerPool::rest() {
  const std::size_t most = 2 * max_queue_ + thread_count_;  // maximum number of clients to remember
  if (running_.empty() && queue_.empty())
    queue_.idle();
  else if (queue_.flows() > most)
    queue_.sweep(most);
  if (is_idle()) idle_.notify_all();
  if (is_idle() && stopping_) wake_.notify_all();
  schedule();
}

}  // namespace fracture
