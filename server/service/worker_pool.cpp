#include "server/service/worker_pool.hpp"

#include <algorithm>
#include <utility>

namespace fracture {

WorkerPool::WorkerPool(int threads, std::size_t max_queue)
    : max_queue_(max_queue), thread_count_(static_cast<std::size_t>(std::max(1, threads))) {
  threads_.reserve(thread_count_);
  for (std::size_t t = 0; t < thread_count_; ++t) threads_.emplace_back([this] { work(); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

WorkerPool::TaskId WorkerPool::submit(Priority priority, double cost, Job job) {
  TaskId id;
  {
    const std::lock_guard lock(mutex_);
    id = next_++;
    (priority == Priority::kRealtime ? realtime_ : batch_)
        .push_back({id, cost, Clock::now(), std::move(job)});
  }
  wake_.notify_one();
  return id;
}

void WorkerPool::resume(Job job) {
  {
    const std::lock_guard lock(mutex_);
    resumed_.push_back({next_++, 0, Clock::now(), std::move(job)});
  }
  wake_.notify_one();
}

void WorkerPool::promote(TaskId task) {
  const std::lock_guard lock(mutex_);
  const auto at = std::find_if(batch_.begin(), batch_.end(), [&](const Task& t) { return t.id == task; });
  if (at == batch_.end()) return;
  // By arrival, which keeps the queue in order.
  const auto place = std::find_if(realtime_.begin(), realtime_.end(),
                                  [&](const Task& t) { return t.arrival > at->arrival; });
  Task moved = std::move(*at);
  batch_.erase(at);
  realtime_.insert(place, std::move(moved));
}

std::optional<std::size_t> WorkerPool::position(TaskId task) const {
  const std::lock_guard lock(mutex_);
  std::size_t before = resumed_.size();
  for (const std::deque<Task>* queue : {&realtime_, &batch_})
    for (const Task& queued : *queue) {
      if (queued.id == task) return before;
      ++before;
    }
  return std::nullopt;
}

void WorkerPool::revise(TaskId task, double cost) {
  const std::lock_guard lock(mutex_);
  if (const auto at = running_.find(task); at != running_.end()) at->second.cost = cost;
}

bool WorkerPool::full() const {
  const std::lock_guard lock(mutex_);
  // An idle worker takes the job at once: such a job does not count as queued.
  const std::size_t idle = thread_count_ - std::min(thread_count_, running_.size());
  return realtime_.size() + batch_.size() >= max_queue_ + idle;
}

void WorkerPool::wait_idle() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return running_.empty() && queued_locked() == 0; });
}

std::chrono::duration<double> WorkerPool::predicted_wait(Priority priority) const {
  const std::lock_guard lock(mutex_);
  if (running_.size() + queued_locked() < thread_count_) return {};
  double ahead = 0;
  for (const Task& task : realtime_) ahead += task.cost;
  if (priority == Priority::kBatch)
    for (const Task& task : batch_) ahead += task.cost;
  ahead *= took_ / cost_;
  const Clock::time_point now = Clock::now();
  for (const auto& [id, running] : running_)
    ahead += std::max(
        0.0, running.cost * took_ / cost_ - std::chrono::duration<double>(now - running.start).count());
  return std::chrono::duration<double>(ahead / static_cast<double>(thread_count_));
}

std::chrono::duration<double> WorkerPool::predicted_run(double cost) const {
  const std::lock_guard lock(mutex_);
  return std::chrono::duration<double>(cost * took_ / cost_);
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

WorkerPool::Task WorkerPool::take() {
  std::deque<Task>* queue = &resumed_;
  if (queue->empty()) {
    queue = &realtime_;
    if (realtime_.empty() || (!batch_.empty() && batch_.front().arrival + kAging < realtime_.front().arrival))
      queue = &batch_;
  }
  Task task = std::move(queue->front());
  queue->pop_front();
  return task;
}

void WorkerPool::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stopping_ || queued_locked() > 0; });
    if (queued_locked() == 0) return;
    Task task = take();
    running_[task.id] = {task.cost, Clock::now()};
    const std::size_t sharing = std::min(thread_count_, running_.size() + queued_locked());
    lock.unlock();

    try {
      task.job(static_cast<int>(thread_count_ / sharing));
    } catch (...) {  // a bug, or no memory even to say that there is none: the others go on
      ++escaped_;
    }
    task.job = nullptr;  // what it holds (a request body) is released here, not when the next job arrives

    lock.lock();
    running_.erase(task.id);
    if (running_.empty() && queued_locked() == 0) idle_.notify_all();
  }
}

}  // namespace fracture
