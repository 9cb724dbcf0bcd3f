// The threads that compute. A bounded queue: when it is full the caller is told at once and tells the client
// when to come back, instead of letting everybody wait for an answer that nobody wants any more.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace fracture {

/// The cores this process may use: the affinity mask, lowered to the CPU quota of the control group (v2 or
/// v1).
int available_cores();

class WorkerPool {
 public:
  /// A job is told how many threads it may use for its own loops: the pool's threads divided among the jobs
  /// that run, so that a lone request uses every core and a loaded server runs one job a core.
  using Job = std::function<void(int threads)>;

  WorkerPool(int threads, std::size_t max_queue);
  /// Finishes what is queued (cancel it through its own stop tokens first when that would take too long).
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// False when the queue is full. Jobs must not throw.
  bool try_submit(Job job);
  bool full() const;

  /// Returns when nothing is queued and nothing runs.
  void wait_idle();

  /// When a place should be free: the work ahead over the measured throughput, at least one second, at most a
  /// minute.
  std::chrono::seconds retry_after() const;

  int threads() const { return static_cast<int>(threads_.size()); }
  std::size_t queued() const;
  std::size_t running() const;

 private:
  void work();

  const std::size_t max_queue_;
  mutable std::mutex mutex_;
  std::condition_variable wake_, idle_;
  std::deque<Job> queue_;
  std::size_t running_ = 0;
  std::size_t thread_count_ = 0;
  double mean_seconds_ = 0.1;  // moving average of a job's duration
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace fracture
