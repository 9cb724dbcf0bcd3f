// The threads that compute, and the queue before them. Two classes: realtime work goes first, but batch work
// ages: a job that has waited kAging longer than a realtime one goes before it, so that neither starves.
// Every job says what it should cost; costs queued over the throughput that was measured is how long a new
// one would wait, so that a client is refused at once instead of waiting for an answer that comes too late.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "server/service/control_group.hpp"

namespace fracture {

enum class Priority { kRealtime, kBatch };

class WorkerPool {
 public:
  /// A job is told how many threads it may use for its own loops: the pool's threads divided among the jobs
  /// that run, so that a lone request uses every core and a loaded server runs one job a core.
  using Job = std::function<void(int threads)>;
  using TaskId = std::uint64_t;

  WorkerPool(int threads, std::size_t max_queue);
  /// Finishes what is queued (cancel it through its own stop tokens first when that would take too long).
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// The id of the task; never refused (look at full() and predicted_wait() first). `cost`: what the job
  /// should take, in seconds of one thread of a machine of nominal speed; measured() says how far off such
  /// estimates are. Jobs must not throw.
  TaskId submit(Priority priority, double cost, Job job);
  /// Work that was admitted before and goes on: never refused, served before everything else.
  void resume(Job job);
  /// A batch task that is still queued becomes a realtime one. Nothing happens when it is not.
  void promote(TaskId task);

  /// What a job that runs turned out to cost, for predictions of the wait. Nothing happens when it does not
  /// run.
  void revise(TaskId task, double cost);

  /// How many tasks go before this one, as things are; nothing when it is not queued.
  std::optional<std::size_t> position(TaskId task) const;

  /// As many tasks wait as may.
  bool full() const;

  /// How long a new job of this class would be queued: what goes before it, over the throughput measured so
  /// far.
  std::chrono::duration<double> predicted_wait(Priority priority) const;
  /// What a job of this cost should take, by the same measure.
  std::chrono::duration<double> predicted_run(double cost) const;

  /// Work of this cost took so many seconds of one thread, over all the jobs it was divided into.
  void measured(double cost, double seconds);

  /// Returns when nothing is queued and nothing runs.
  void wait_idle();

  int threads() const { return static_cast<int>(threads_.size()); }
  std::size_t queued() const;
  std::size_t running() const;
  /// Jobs that threw, though they must not.
  std::uint64_t escaped() const { return escaped_; }

  /// A batch job is served before realtime jobs that came this much later.
  static constexpr std::chrono::milliseconds kAging{1000};

 private:
  using Clock = std::chrono::steady_clock;
  struct Task {
    TaskId id;
    double cost;
    Clock::time_point arrival;
    Job job;
  };
  struct Running {
    double cost;
    Clock::time_point start;
  };

  void work();
  std::size_t queued_locked() const { return resumed_.size() + realtime_.size() + batch_.size(); }
  Task take();

  const std::size_t max_queue_;
  mutable std::mutex mutex_;
  std::condition_variable wake_, idle_;
  std::deque<Task> resumed_, realtime_, batch_;
  std::map<TaskId, Running> running_;
  TaskId next_ = 1;
  std::size_t thread_count_ = 0;
  /// Decaying sums over what was measured: seconds it took, seconds it was said to take.
  double took_ = 0.1, cost_ = 0.1;
  std::atomic<std::uint64_t> escaped_{0};
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace fracture
