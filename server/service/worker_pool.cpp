#include "server/service/worker_pool.hpp"

#include <algorithm>
#include <utility>

#include "common/base/processor_time.hpp"

namespace fracture {
namespace {

using Seconds = std::chrono::duration<double>;

}  // namespace

/// A job on its thread. Everything that is not said to be otherwise is guarded by the pool's mutex.
class WorkerPool::Running final : public Turn {
 public:
  Running(WorkerPool& its_pool, Priority its_priority, double its_cost)
      : pool(its_pool), priority(its_priority), cost(its_cost) {}

  void give_way() override {
    if (!pool.urgent_.load(std::memory_order_relaxed)) return;
    std::unique_lock lock(pool.mutex_);
    if (priority == Priority::kRealtime) return;
    const auto must = [this] {
      return pool.realtime_waits() ? !pool.may_begin_realtime() : pool.computing() > pool.thread_count_;
    };
    if (!paused) {
      if (Clock::now() < works_until || !must()) return;
      paused = true;
      paused_since = Clock::now();
      pool.changed();
    }
    // Every thread of the job waits here; the first that may go on lets all of them.
    pool.go_on_.wait_until(lock, paused_since + kLongestPause, [this] {
      return !paused || priority == Priority::kRealtime || pool.stopping_ ||
             (!pool.realtime_waits() && pool.computing() < pool.thread_count_);
    });
    if (!paused) return;
    paused = false;
    const Clock::duration stood = Clock::now() - paused_since;
    paused_for += stood;
    works_until = Clock::now() + std::max<Clock::duration>(kLeastWork, stood / 4);
    pool.go_on_.notify_all();
    pool.changed();
  }

  void leave() override {
    left_at = Clock::now();
    computed_before = processor_seconds_of_this_thread();
    const std::lock_guard lock(pool.mutex_);
    away = priority == Priority::kBatch;
    pool.changed();
  }

  void come_back() override {
    const double computed = processor_seconds_of_this_thread() - computed_before;
    away_for += std::max(0.0, Seconds(Clock::now() - left_at).count() - computed);
    const std::lock_guard lock(pool.mutex_);
    away = false;
    pool.changed();
  }

  bool computes() const { return !paused && !away; }

  WorkerPool& pool;
  Priority priority;
  double cost;
  const Clock::time_point start = Clock::now();
  bool paused = false, away = false;
  Clock::time_point paused_since{}, works_until{};
  Clock::duration paused_for{};
  // Of the job's own thread alone.
  Clock::time_point left_at{};
  double computed_before = 0, away_for = 0;

  static thread_local Running* of_this_thread;
};

thread_local WorkerPool::Running* WorkerPool::Running::of_this_thread = nullptr;

Turn* WorkerPool::turn() { return Running::of_this_thread; }

double WorkerPool::paused_seconds() {
  const Running* const mine = Running::of_this_thread;
  if (!mine) return 0;
  const std::lock_guard lock(mine->pool.mutex_);
  return Seconds(mine->paused_for).count();
}

double WorkerPool::away_seconds() {
  const Running* const mine = Running::of_this_thread;
  return mine ? mine->away_for : 0;
}

WorkerPool::WorkerPool(int threads, std::size_t max_queue)
    : max_queue_(max_queue), thread_count_(static_cast<std::size_t>(std::max(1, threads))) {
  // Half of them wait for batch jobs to stand back: as many jobs compute at the same time as was asked for.
  threads_.reserve(2 * thread_count_);
  for (std::size_t t = 0; t < 2 * thread_count_; ++t) threads_.emplace_back([this] { work(); });
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
  (priority == Priority::kRealtime ? realtime_ : batch_)
      .queue.push({id, cost, flow, Clock::now(), std::move(job)});
  changed();
  return id;
}

WorkerPool::TaskId WorkerPool::resume(Job job, Priority priority) {
  const std::lock_guard lock(mutex_);
  const TaskId id = next_++;
  (priority == Priority::kRealtime ? realtime_ : batch_)
      .resumed.push_back({id, 0, {}, Clock::now(), std::move(job)});
  changed();
  return id;
}

bool WorkerPool::promote(TaskId task, const Flow& flow) {
  const std::lock_guard lock(mutex_);
  bool is_queued = false;
  const auto resumed = std::find_if(batch_.resumed.begin(), batch_.resumed.end(),
                                    [&](const Task& waits) { return waits.id == task; });
  if (const auto at = running_.find(task); at != running_.end()) {
    at->second->priority = Priority::kRealtime;
    at->second->away = false;
    go_on_.notify_all();
  } else if (resumed != batch_.resumed.end()) {
    realtime_.resumed.push_back(std::move(*resumed));
    batch_.resumed.erase(resumed);
  } else if (std::optional<Task> queued = batch_.queue.remove(task)) {
    queued->flow = flow;
    realtime_.queue.push(std::move(*queued));
    is_queued = true;
  }
  changed();
  return is_queued;
}

bool WorkerPool::withdraw(TaskId task) {
  std::unique_lock lock(mutex_);
  std::optional<Task> withdrawn = realtime_.queue.remove(task);
  if (!withdrawn) withdrawn = batch_.queue.remove(task);
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
  (priority == Priority::kRealtime ? realtime_ : batch_).queue.charge(flow, seconds);
}

std::optional<std::size_t> WorkerPool::position(TaskId task) const {
  const std::lock_guard lock(mutex_);
  std::size_t before = realtime_.resumed.size() + batch_.resumed.size();
  for (const Class* queued : {&realtime_, &batch_})
    for (const TaskId id : queued->queue.order()) {
      if (id == task) return before;
      ++before;
    }
  return std::nullopt;
}

void WorkerPool::revise(TaskId task, double cost) {
  const std::lock_guard lock(mutex_);
  if (const auto at = running_.find(task); at != running_.end()) at->second->cost = cost;
}

bool WorkerPool::full(const Flow& flow) const {
  const std::lock_guard lock(mutex_);
  // An idle worker takes the job at once: such a job does not count as queued.
  const std::size_t idle = thread_count_ - std::min(thread_count_, running_.size());
  const std::size_t waiting = realtime_.queue.size() + batch_.queue.size();
  if (waiting < max_queue_ + idle) return false;
  // Each further flow has a place for its first task, and addresses are many.
  if (waiting >= 2 * max_queue_ + idle) return true;
  const std::size_t own = realtime_.queue.size_of(flow.name) + batch_.queue.size_of(flow.name);
  const std::size_t others = realtime_.queue.busy_flows() + batch_.queue.busy_flows() - (own > 0 ? 1 : 0);
  // Who fills the queue leaves the others their part of it.
  return max_queue_ == 0 || own >= std::max<std::size_t>(1, max_queue_ / (others + 1));
}

void WorkerPool::wait_idle() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return is_idle(); });
}

std::chrono::duration<double> WorkerPool::predicted_wait(Priority priority, const Flow& flow) const {
  const std::lock_guard lock(mutex_);
  if (running_.size() + queued_locked() < thread_count_) return {};
  double ahead = priority == Priority::kRealtime ? realtime_.queue.ahead_of(flow)
                                                 : realtime_.queue.cost() + batch_.queue.ahead_of(flow);
  ahead *= took_ / cost_;
  const Clock::time_point now = Clock::now();
  for (const auto& [id, job] : running_)
    if (priority == Priority::kBatch || job->priority == Priority::kRealtime)  // the others stand back
      ahead += std::max(0.0, job->cost * took_ / cost_ - Seconds(now - job->start).count());
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
  return static_cast<std::size_t>(
      std::count_if(running_.begin(), running_.end(), [](const auto& job) { return job.second->paused; }));
}

std::size_t WorkerPool::queued_locked() const {
  return realtime_.resumed.size() + realtime_.queue.size() + batch_.resumed.size() + batch_.queue.size();
}

std::size_t WorkerPool::running_of(Priority priority) const {
  return static_cast<std::size_t>(std::count_if(
      running_.begin(), running_.end(), [&](const auto& job) { return job.second->priority == priority; }));
}

std::size_t WorkerPool::computing() const {
  return static_cast<std::size_t>(std::count_if(running_.begin(), running_.end(),
                                                [](const auto& job) { return job.second->computes(); }));
}

bool WorkerPool::may_begin_realtime() const {
  if (running_.size() == 2 * thread_count_) return false;
  const std::size_t now = computing();
  return now < thread_count_ ||
         (now == thread_count_ && thread_count_ > 1 && running_of(Priority::kRealtime) == 0);
}

std::optional<WorkerPool::Next> WorkerPool::next() const {
  const bool realtime = realtime_waits() && may_begin_realtime();
  // Who stands still goes on before others begin; who is away comes back to its place.
  const bool batch =
      (!batch_.resumed.empty() || !batch_.queue.empty()) && computing() < thread_count_ &&
      running_of(Priority::kBatch) < thread_count_ &&
      std::none_of(running_.begin(), running_.end(), [](const auto& job) { return job.second->paused; });
  if (realtime && !realtime_.resumed.empty()) return Next{Priority::kRealtime, true};
  if (batch && realtime) {
    const Task& first = batch_.resumed.empty() ? *batch_.queue.front() : batch_.resumed.front();
    if (first.arrival + kAging < realtime_.queue.front()->arrival)
      return Next{Priority::kBatch, !batch_.resumed.empty()};
  }
  if (realtime) return Next{Priority::kRealtime, false};
  if (batch) return Next{Priority::kBatch, !batch_.resumed.empty()};
  return std::nullopt;
}

WorkerPool::Task WorkerPool::take(Next next) {
  Class& from = next.priority == Priority::kRealtime ? realtime_ : batch_;
  if (!next.resumed) return from.queue.pop();
  Task task = std::move(from.resumed.front());
  from.resumed.pop_front();
  return task;
}

/// Tells whom a change concerns.
void WorkerPool::changed() {
  const bool waits = realtime_waits();
  urgent_ = waits || computing() > thread_count_;
  if (next()) wake_.notify_one();
  if (!waits && computing() < thread_count_) go_on_.notify_all();
}

void WorkerPool::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    std::optional<Next> chosen;
    wake_.wait(lock, [&] { return (chosen = next()) || (stopping_ && queued_locked() == 0); });
    if (!chosen) return;
    Task task = take(*chosen);
    Running job(*this, chosen->priority, task.cost);
    running_[task.id] = &job;
    const std::size_t sharing = std::clamp<std::size_t>(computing() + queued_locked(), 1, thread_count_);
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
  if (is_idle()) {
    realtime_.queue.idle();
    batch_.queue.idle();
    idle_.notify_all();
    if (stopping_) wake_.notify_all();
  } else if (realtime_.queue.flows() + batch_.queue.flows() > 2 * max_queue_ + thread_count_) {
    realtime_.queue.sweep();
    batch_.queue.sweep();
  }
  changed();
}

}  // namespace fracture
