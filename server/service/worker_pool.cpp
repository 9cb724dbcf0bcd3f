#include "server/service/worker_pool.hpp"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <utility>

namespace fracture {
namespace {

/// Quota over period of the control group, 0 when there is none.
double cgroup_cores() {
  if (std::ifstream v2("/sys/fs/cgroup/cpu.max"); v2) {
    std::string quota;
    double period = 0;
    if (v2 >> quota >> period && quota != "max" && period > 0)
      return std::strtod(quota.c_str(), nullptr) / period;
    return 0;
  }
  std::ifstream quota_file("/sys/fs/cgroup/cpu/cpu.cfs_quota_us"),
      period_file("/sys/fs/cgroup/cpu/cpu.cfs_period_us");
  double quota = 0, period = 0;
  if (quota_file >> quota && period_file >> period && quota > 0 && period > 0) return quota / period;
  return 0;
}

}  // namespace

int available_cores() {
  int cores = static_cast<int>(std::thread::hardware_concurrency());
  cpu_set_t mask;
  if (sched_getaffinity(0, sizeof mask, &mask) == 0) cores = CPU_COUNT(&mask);
  if (const double quota = cgroup_cores(); quota > 0)
    cores = std::min(cores, static_cast<int>(std::ceil(quota)));
  return std::max(1, cores);
}

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

bool WorkerPool::try_submit(Job job) {
  {
    const std::lock_guard lock(mutex_);
    // An idle worker takes the job at once: such a job does not count as queued.
    const std::size_t idle = thread_count_ - std::min(thread_count_, running_);
    if (queue_.size() >= max_queue_ + idle) return false;
    queue_.push_back(std::move(job));
  }
  wake_.notify_one();
  return true;
}

bool WorkerPool::full() const {
  const std::lock_guard lock(mutex_);
  return queue_.size() >= max_queue_ + (thread_count_ - std::min(thread_count_, running_));
}

void WorkerPool::wait_idle() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return running_ == 0 && queue_.empty(); });
}

std::chrono::seconds WorkerPool::retry_after() const {
  const std::lock_guard lock(mutex_);
  const double ahead = static_cast<double>(queue_.size() + running_);
  const double seconds = std::ceil(ahead * mean_seconds_ / static_cast<double>(thread_count_));
  return std::chrono::seconds(static_cast<int>(std::clamp(seconds, 1.0, 60.0)));
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

std::size_t WorkerPool::running() const {
  const std::lock_guard lock(mutex_);
  return running_;
}

void WorkerPool::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
    if (queue_.empty()) return;
    Job job = std::move(queue_.front());
    queue_.pop_front();
    ++running_;
    const std::size_t sharing = std::min(thread_count_, running_ + queue_.size());
    lock.unlock();

    const auto start = std::chrono::steady_clock::now();
    job(static_cast<int>(thread_count_ / sharing));
    job = nullptr;  // what the job holds (a request body) is released here, not when the next job arrives
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;

    lock.lock();
    --running_;
    if (running_ == 0 && queue_.empty()) idle_.notify_all();
    mean_seconds_ += 0.1 * (took.count() - mean_seconds_);
  }
}

}  // namespace fracture
