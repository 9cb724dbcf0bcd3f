// The threads that compute, and the queues before them. Three classes: realtime work (a collision) goes before
// batch work (a client waits for the answer), and that before background work (jobs that nobody waits for). But
// work ages: a task that has waited kAging longer than one of a more urgent class goes before it, so that none
// starves. Within a class the flows (names, addresses) take turns by what they have used (fair_queue.hpp).
// Every task says what it should cost; costs queued over the throughput that was measured is how long a new
// one would wait, so that a client is refused at once instead of waiting for an answer that comes too late.
//
// No work waits for that of a less urgent class to end. A batch or background computation that polls
// (base/execution.hpp) while more urgent work waits for a processor stands still there and leaves it its
// processor; the urgent task runs on a thread of its own, since a computation's scratch memory belongs to its
// thread. It stands still for kLongestPause at most and then computes for a quarter of that at least: nothing
// it holds (a place among the import workers, a value that others wait for) can be held for ever, and it gets a
// fifth of the time even where urgent work never ends. Where there are two threads or more, realtime work need
// not even wait for the poll: beside jobs on all of them one realtime job more is begun at once, and whoever
// polls first makes room.
//
// A task that runs may change its class, and those who hurry it by turns may do so for ever. So it is of a class for a
// limited time in all (Longest), and of the next one from then on. As many tasks begin in a class as there are threads,
// and each keeps its place there while it is more urgent. So where too many run, it is those who began in a more urgent
// class: they end at their next poll (kOverloaded), or they would keep threads from more urgent work for as long as
// they take.
#pragma once

#include <array>
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

#include "common/base/turn.hpp"
#include "server/service/control_group.hpp"
#include "server/service/fair_queue.hpp"

namespace fracture {

/// The most urgent first.
enum class Priority { kRealtime, kBatch, kBackground };

/// For how long a task that runs is realtime, or batch work, in all: nobody waits longer in that class.
struct Longest {
  std::chrono::milliseconds realtime{2'000}, batch{60'000};
};

class WorkerPool {
 public:
  /// A job is told how many threads it may use for its own loops: the pool's threads divided among the jobs
  /// that run, so that a lone request uses every core and a loaded server runs one job a core.
  using Job = std::function<void(int threads)>;
  using TaskId = std::uint64_t;

  /// `threads`: jobs that compute at the same time.
  WorkerPool(int threads, std::size_t max_queue, const Longest& longest = {});
  /// Finishes what is queued (cancel it through its own stop tokens first when that would take too long).
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// The id of the task; never refused (look at full() and predicted_wait() first). `cost`: what the job
  /// should take, in seconds of one thread of a machine of nominal speed; measured() says how far off such
  /// estimates are. Jobs must not throw.
  TaskId submit(Priority priority, double cost, Job job, const Flow& flow = {});
  /// Work that was admitted before and goes on: never refused, and every other task of its class that begins is
  /// such a one while any wait. `cost`: what is left of it; `origin`: the class in which it was submitted.
  TaskId resume(Job job, Priority priority = Priority::kRealtime, double cost = 0,
                std::optional<Priority> origin = std::nullopt);
  /// A task is of this class from now on, queued or running, or of the most urgent one that is left to it (Longest).
  /// Nothing happens when it is neither, or of that class already. True: it is queued, and takes the turn of this flow
  /// there instead of the one that it had.
  bool reclassify(TaskId task, Priority priority, const Flow& flow = {});
  /// A task that is queued does not run. False where it is not: it has begun, or was resumed.
  bool withdraw(TaskId task);
  /// A flow has used so many seconds more (or less) than the costs of its tasks said.
  void charge(Priority priority, const Flow& flow, double seconds);

  /// Of the job that the calling thread runs, for its Execution; null on other threads.
  static Turn* turn();
  /// Seconds for which the job that the calling thread runs was made to stand still, by now.
  static double paused_seconds();
  /// Processor seconds that went into it in other processes (Turn::spent_elsewhere), by now.
  static double seconds_elsewhere();

  /// What a job that runs turned out to cost, for predictions of the wait. Nothing happens when it does not
  /// run.
  void revise(TaskId task, double cost);

  /// How many tasks go before each of these, as things are; nothing for one that is not queued, and for all of them
  /// while more than kMostPlaced wait: everybody waits for the lock meanwhile.
  std::vector<std::optional<std::size_t>> positions(const std::vector<TaskId>& tasks) const;
  static constexpr std::size_t kMostPlaced = 3000;

  /// As many tasks wait as may (max_queue), and of this flow as many as its part of them; or twice as many,
  /// whoever comes: who fills the queue leaves the others their part, up to here. Background tasks are counted
  /// for themselves: they may wait for long, and nobody else is turned away for them.
  bool full(Priority priority, const Flow& flow = {}) const;

  /// How long a new job of this class and flow would be queued: what goes before it, over the throughput
  /// measured so far.
  std::chrono::duration<double> predicted_wait(Priority priority, const Flow& flow = {}) const;
  /// What a job of this cost should take, by the same measure.
  std::chrono::duration<double> predicted_run(double cost) const;

  /// Work of this cost took so many seconds of one thread, over all the jobs it was divided into.
  void measured(double cost, double seconds);

  /// Returns when nothing is queued and nothing runs.
  void wait_idle();

  int threads() const { return static_cast<int>(thread_count_); }
  std::size_t queued() const;
  std::size_t running() const;
  /// Jobs that stand still for more urgent ones, now.
  std::size_t paused() const;
  /// Jobs that threw, though they must not.
  std::uint64_t escaped() const { return escaped_; }

  /// A task is served before more urgent ones that came this much later.
  static constexpr std::chrono::milliseconds kAging{1000};
  /// A job stands still for at most this long at once ...
  static constexpr std::chrono::milliseconds kLongestPause{250};
  /// ... and then not again for a quarter of the time that it stood still, or this.
  static constexpr std::chrono::milliseconds kLeastWork{10};

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr Clock::rep kNever = Clock::duration::max().count();
  struct Task {
    TaskId id;
    double cost;
    Flow flow;
    Clock::time_point arrival;
    Job job;
    Priority origin;  ///< the class in which it was submitted
  };
  class Running;
  struct Class {
    bool waits() const { return !resumed.empty() || !queue.empty(); }
    bool resumed_is_next() const { return !resumed.empty() && (queue.empty() || !resumed_was_last); }
    const Task& front() const { return resumed_is_next() ? resumed.front() : *queue.front(); }

    bool resumed_was_last = false;
    std::deque<Task> resumed;
    FairQueue<Task> queue;
  };
  struct Next {
    Priority priority;
    bool resumed;
  };

  void work();
  /// Some task has been of its class for long enough, and somebody waits. Without the lock.
  bool some_class_ended() const;
  std::size_t most_running() const { return classes_.size() * thread_count_; }
  // All of these with the lock.
  std::size_t queued_locked() const;
  bool is_idle() const { return running_.empty() && withdrawing_ == 0 && queued_locked() == 0; }
  std::size_t running_of(Priority priority) const;
  /// Which run and are of this class, or began there and are more urgent now.
  std::size_t places_of(Priority priority) const;
  /// Jobs that compute, of this class and more urgent ones.
  std::size_t computing(Priority least = Priority::kBackground) const;
  bool any_paused(Priority least) const;
  Class& of(Priority priority) { return classes_[static_cast<std::size_t>(priority)]; }
  const Class& of(Priority priority) const { return classes_[static_cast<std::size_t>(priority)]; }
  /// There is a thread for one more of this class. Each class has as many as may compute, the last of them are
  /// for realtime jobs alone; who is away or stands still keeps its own.
  bool has_thread(Priority priority) const;
  bool may_begin(Priority priority) const;
  /// Somebody more urgent than this class lacks the processor of one of its jobs.
  bool must_stand_back(Priority priority) const;
  /// Nobody more urgent than this class has a use for the processor that is free.
  bool may_go_on(Priority priority) const;
  std::optional<Next> next() const;
  Task take(Next next);
  /// A task that runs is of this class from now on, or of the one that is left to it.
  void become(Running& job, Priority priority);
  /// Those that were of their class for long enough are so no longer.
  void end_classes();
  /// Those end that are too many.
  void thin_out();
  void changed();
  void rest();

  const std::size_t max_queue_;
  const std::array<Clock::duration, 2> longest_;  ///< by Priority
  mutable std::mutex mutex_;
  std::condition_variable wake_, idle_, go_on_;
  std::array<Class, 3> classes_;
  std::map<TaskId, Running*> running_;
  TaskId next_ = 1;
  std::size_t withdrawing_ = 0;  ///< tasks that were taken out of the queue and are being released
  std::size_t thread_count_ = 0;
  /// Somebody who computes should stand back: read at every poll, without the lock.
  std::atomic<bool> urgent_{false};
  /// When the next task has been of its class for long enough, while somebody waits, by Clock. Read like urgent_.
  std::atomic<Clock::rep> class_ends_{kNever};
  /// Decaying sums over what was measured: seconds it took, seconds it was said to take.
  double took_ = 0.1, cost_ = 0.1;
  std::atomic<std::uint64_t> escaped_{0};
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace fracture
