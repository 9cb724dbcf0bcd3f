#include "server/service/worker_pool.hpp"

#include <algorithm>
#include <utility>

#include "common/base/processor_time.hpp"

namespace fracture {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr std::array kAll = {Priority::kRealtime, Priority::kBatch, Priority::kBackground};

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
    if (!paused) {
      if (Clock::now() < works_until || !pool.must_stand_back(priority)) return;
      paused = true;
      paused_since = Clock::now();
      pool.changed();
    }
    // Every thread of the job waits here; the first that may go on lets all of them.
    pool.go_on_.wait_until(lock, paused_since + kLongestPause, [this] {
      return !paused || priority == Priority::kRealtime || pool.stopping_ || pool.may_go_on(priority);
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
    away = priority != Priority::kRealtime;
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
  of(priority).queue.push({id, cost, flow, Clock::now(), std::move(job)});
  changed();
  return id;
}

WorkerPool::TaskId WorkerPool::resume(Job job, Priority priority) {
  const std::lock_guard lock(mutex_);
  const TaskId id = next_++;
  of(priority).resumed.push_back({id, 0, {}, Clock::now(), std::move(job)});
  changed();
  return id;
}

bool WorkerPool::promote(TaskId task, Priority priority, const Flow& flow) {
  const std::lock_guard lock(mutex_);
  bool is_queued = false;
  if (const auto at = running_.find(task); at != running_.end()) {
    Running& job = *at->second;
    job.priority = std::min(job.priority, priority);
    job.away = job.away && job.priority != Priority::kRealtime;
    go_on_.notify_all();
  }
  for (const Priority less : kAll) {
    if (less <= priority) continue;
    std::deque<Task>& resumed = of(less).resumed;
    const auto waiting =
        std::find_if(resumed.begin(), resumed.end(), [&](const Task& waits) { return waits.id == task; });
    if (waiting != resumed.end()) {
      of(priority).resumed.push_back(std::move(*waiting));
      resumed.erase(waiting);
    } else if (std::optional<Task> queued = of(less).queue.remove(task)) {
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
  for (const Priority priority : kAll)
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

std::optional<std::size_t> WorkerPool::position(TaskId task) const {
  const std::lock_guard lock(mutex_);
  std::size_t before = 0;
  for (const Class& queued : classes_) before += queued.resumed.size();
  for (const Class& queued : classes_)
    for (const TaskId id : queued.queue.order()) {
      if (id == task) return before;
      ++before;
    }
  return std::nullopt;
}

void WorkerPool::revise(TaskId task, double cost) {
  const std::lock_guard lock(mutex_);
  if (const auto at = running_.find(task); at != running_.end()) at->second->cost = cost;
}

bool WorkerPool::full(Priority priority, const Flow& flow) const {
  const std::lock_guard lock(mutex_);
  // An idle worker takes the job at once: such a job does not count as queued.
  const std::size_t idle = thread_count_ - std::min(thread_count_, running_.size());
  std::size_t waiting = 0, own = 0, busy = 0;
  for (const Priority counted : kAll) {
    if ((counted == Priority::kBackground) != (priority == Priority::kBackground)) continue;
    const FairQueue<Task>& queue = of(counted).queue;
    waiting += queue.size();
    own += queue.size_of(flow.name);
    busy += queue.busy_flows();
  }
  if (waiting < max_queue_ + idle) return false;
  // Each further flow has a place for its first task, and addresses are many.
  if (waiting >= 2 * max_queue_ + idle) return true;
  const std::size_t others = busy - (own > 0 ? 1 : 0);
  // Who fills the queue leaves the others their part of it.
  return max_queue_ == 0 || own >= std::max<std::size_t>(1, max_queue_ / (others + 1));
}

void WorkerPool::wait_idle() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return is_idle(); });
}

std::chrono::duration<double> WorkerPool::predicted_wait(Priority priority, const Flow& flow) const {
  const std::lock_guard lock(mutex_);
  std::size_t tasks = 0;
  double ahead = 0;
  for (const Priority before : kAll) {
    if (before > priority) continue;  // those stand back
    const Class& queued = of(before);
    tasks += queued.resumed.size() + queued.queue.size() + running_of(before);
    ahead += before < priority ? queued.queue.cost() : queued.queue.ahead_of(flow);
  }
  if (tasks < thread_count_) return {};
  ahead *= took_ / cost_;
  const Clock::time_point now = Clock::now();
  for (const auto& [id, job] : running_)
    if (job->priority <= priority)
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
  std::size_t queued = 0;
  for (const Class& waits : classes_) queued += waits.resumed.size() + waits.queue.size();
  return queued;
}

std::size_t WorkerPool::running_of(Priority priority) const {
  return static_cast<std::size_t>(std::count_if(
      running_.begin(), running_.end(), [&](const auto& job) { return job.second->priority == priority; }));
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

bool WorkerPool::may_begin(Priority priority) const {
  const std::size_t now = computing();
  if (priority == Priority::kRealtime)
    return running_.size() < most_running() &&
           (now < thread_count_ || (now == thread_count_ && thread_count_ > 1 && running_of(priority) == 0));
  // Who stands still goes on before others begin; who is away comes back to its place.
  return now < thread_count_ && running_of(priority) < thread_count_ && !any_paused(priority);
}

bool WorkerPool::must_stand_back(Priority priority) const {
  if (computing(priority) > thread_count_) return true;
  if (computing() < thread_count_) return false;
  for (const Priority urgent : kAll) {
    if (urgent >= priority) break;
    const bool has_places = urgent == Priority::kRealtime || running_of(urgent) < thread_count_;
    if (any_paused(urgent) || (of(urgent).waits() && has_places && !may_begin(urgent))) return true;
  }
  return false;
}

bool WorkerPool::may_go_on(Priority priority) const {
  if (computing() >= thread_count_) return false;
  for (const Priority urgent : kAll) {
    if (urgent >= priority) break;
    if (any_paused(urgent) || (of(urgent).waits() && may_begin(urgent))) return false;
  }
  return true;
}

std::optional<WorkerPool::Next> WorkerPool::next() const {
  std::optional<Next> chosen;
  for (const Priority priority : kAll) {
    const Class& waiting = of(priority);
    if (!waiting.waits() || !may_begin(priority)) continue;
    const bool aged = chosen && waiting.front().arrival + kAging < of(chosen->priority).front().arrival;
    if (!chosen || aged) chosen = Next{priority, !waiting.resumed.empty()};
    if (chosen->resumed) break;
  }
  return chosen;
}

WorkerPool::Task WorkerPool::take(Next next) {
  Class& from = of(next.priority);
  if (!next.resumed) return from.queue.pop();
  Task task = std::move(from.resumed.front());
  from.resumed.pop_front();
  return task;
}

/// Tells whom a change concerns.
void WorkerPool::changed() {
  const auto some_must = [this](Priority priority) {
    return running_of(priority) > 0 && must_stand_back(priority);
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
  std::size_t flows = 0;
  for (const Class& queued : classes_) flows += queued.queue.flows();
  if (is_idle()) {
    for (Class& queued : classes_) queued.queue.idle();
    idle_.notify_all();
    if (stopping_) wake_.notify_all();
  } else if (flows > 2 * max_queue_ + thread_count_) {
    for (Class& queued : classes_) queued.queue.sweep();
  }
  changed();
}

}  // namespace fracture
