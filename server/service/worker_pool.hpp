// The threads that compute, and the tasks that use them. There are three classes. Realtime work (a collision) goes before
// batch work (a client waits for the answer), which goes before background work (jobs that nobody waits for). Among clients
// (names, addresses), the one that has used less processor time goes first, whatever the class; fair_queue.hpp explains how
// the two rules combine. Every task states its expected cost. The predicted wait of a new task follows from the costs of the
// tasks before it and the pace of their clients (pace.hpp). So a client is refused at once instead of waiting for an answer
// that would be too late.
//
// These rules apply all the time, not only when tasks begin. A task's use is charged at its polls (base/execution.hpp), some
// hundred times a second. Normally, threads() tasks compute at the same time. If a task that waits or stands still is entitled
// to compute now, it takes the place of the least entitled task, which stands still at its next poll. A computation's scratch
// memory belongs to its thread, so each task has its own thread; threads are started when they are needed. With two or more
// processors, realtime work need not even wait for that poll. If other tasks compute on all processors, one realtime task
// begins at once, and the first task that polls makes room.
//
// No task stands still forever, because other clients use up their turns. Within a client, a task that has stood still for
// kLongestPause while another one computes goes on for a quarter of that time. One task at a time may do so in addition to
// threads(). So a task never blocks others forever with a value that they wait for. And each class of a client gets its part
// of the time, even if more urgent work never ends.
//
// A client that exceeds its processor rate (tenants/account.hpp) computes nothing until it is within the rate again. The
// exception is tasks that other clients are also waiting for.
//
// A running task may change its class, and clients could take turns hurrying it forever. So a task's total time in a class is
// limited (Longest); after that it moves to the next class. A client can begin as many tasks in a class as there are
// processors, and a task keeps its place in that class while it is more urgent. So if too many tasks run in a class, some of
// them began in a more urgent class. These end at their next poll (kOverloaded), because they would otherwise occupy threads
// for as long as they take.
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
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "common/base/turn.hpp"
#include "server/service/control_group.hpp"
#include "server/service/fair_queue.hpp"
#include "server/service/pace.hpp"

namespace fracture {

/// How long a running task may be realtime or batch work in total. It holds up other work of that class no longer than this.
struct Longest {
  std::chrono::milliseconds realtime{2'000}, batch{60'000};
};

struct Execution;

class WorkerPool {
 public:
  /// `threads`: how many threads the job may use for its own loops. The pool divides its threads among the running jobs, so
  /// that a lone request uses all cores and a loaded server runs one job per core.
  using Job = std::function<void(int threads)>;
  /// Called on the job's thread, at some of its polls and at its end, with the seconds that the job has used since the last
  /// call. It must charge the clients for which the job runs.
  using Used = std::function<void(double seconds)>;
  using TaskId = std::uint64_t;

  /// `threads`: maximum number of jobs that compute at the same time.
  WorkerPool(int threads, std::size_t max_queue, const Longest& longest = {});
  /// Finishes all queued jobs. If that would take too long, cancel them first through their stop tokens.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Queues a job and returns the task's id. Never refuses a job, so check full() and predicted_wait() first. `cost`: expected
  /// time in seconds on one thread of the reference machine; measured() corrects such estimates. `used`: if it is empty, the
  /// flow is charged. Jobs must not throw.
  TaskId submit(Priority priority, double cost, Job job, const Flow& flow = {}, Used used = {});
  /// Queues a job that continues work which was admitted before. Never refused. While resumed tasks wait, they alternate with
  /// the other tasks of their client and class. `cost`: remaining cost; `origin`: the class in which the work was submitted.
  TaskId resume(Job job, Priority priority = Priority::kRealtime, double cost = 0,
                std::optional<Priority> origin = std::nullopt, const Flow& flow = {}, Used used = {});
  /// Moves a queued or running task to this class. If a running task's time in that class is used up (Longest), it moves to
  /// the next class instead. Does nothing if the task has ended or already has this class. Returns true if the task is queued;
  /// it then takes the turn of this flow instead of its old one.
  bool reclassify(TaskId task, Priority priority, const Flow& flow = {});
  /// Call when another client in the same class is also waiting for the task. If the task is queued and this flow's turn
  /// comes sooner, the task takes that turn, and the function returns true.
  bool hasten(TaskId task, const Flow& flow);
  /// Call when another client is also waiting for the task. From now on, the task runs even if its first client exceeds its
  /// processor rate.
  void share(TaskId task);
  /// Removes a queued task, so that it never runs. Returns false if it has begun or was resumed.
  bool withdraw(TaskId task);
  /// As above, but for a resumed task. The caller must end the work that the task would have continued.
  bool withdraw_resumed(TaskId task);
  /// Ends a running task at its next poll (kOverloaded), because other tasks need what it holds. Returns false if the task
  /// does not run, or is more urgent than `most`.
  bool give_up(TaskId task, Priority most = Priority::kBackground);
  /// Charges a flow and its account for the seconds used.
  void charge(Priority priority, const Flow& flow, double seconds);

  // The following functions concern the job that the calling thread runs.

  /// Returns the job's turn, for its Execution; null on other threads.
  static Turn* turn();
  /// Returns the flow whose turn the job takes; an unnamed flow on other threads.
  static Flow flow();
  /// Charges everything that the job has used so far.
  static void charge_by_now();
  /// Tells the pool the job's stop token and deadline. A job that stands still continues when it is stopped or past its
  /// deadline, so that its poll can end it.
  static void stands_still_while_wanted(const Execution& execution);
  /// Returns whether the job stands still, or should do so at its next poll.
  static bool stands_back();
  /// Returns for how many seconds the job has stood still so far.
  static double paused_seconds();
  /// Returns how many processor seconds other processes have used for the job so far (Turn::spent_elsewhere).
  static double seconds_elsewhere();

  /// Updates the cost of a running job, for predictions of the wait. Does nothing if the task does not run.
  void revise(TaskId task, double cost);

  /// Returns how many tasks currently go before each of these; nothing for a task that is not queued. If more than kMostPlaced
  /// tasks wait, returns nothing for all of them, because the lock would be held for too long.
  std::vector<std::optional<std::size_t>> positions(const std::vector<TaskId>& tasks) const;
  static constexpr std::size_t kMostPlaced = 1000;

  /// Returns whether this flow already has as many waiting tasks as it may have. The limit is max_queue if no other flow
  /// waits, and otherwise the flow's part of 2 * max_queue (FairShare). A flow's first task is accepted while fewer than
  /// 4 * max_queue tasks wait, so that there is room for newcomers. Background tasks are counted separately: they may wait for
  /// a long time, and must not cause other tasks to be refused.
  bool full(Priority priority, const Flow& flow = {}) const;

  /// Returns how long a new job of this class, flow and cost would be queued or stand still. This is the time of all other
  /// work computed before it ends, at the measured pace of each client.
  std::chrono::duration<double> predicted_wait(Priority priority, const Flow& flow = {},
                                               double cost = 0) const;
  /// Returns how long all waiting and running work of this class and of more urgent ones would take. This is the wait of the
  /// client that has used the most time, and it shows whether more servers are needed.
  std::chrono::duration<double> backlog(Priority priority) const;
  /// Returns how many seconds a job of this client and cost should take, at the client's measured pace.
  std::chrono::duration<double> predicted_run(const std::string& client, double cost) const;

  /// Records how many seconds on one thread work of this client and cost took, summed over all its jobs.
  void measured(const std::string& client, double cost, double seconds);

  /// Blocks until nothing is queued and nothing runs.
  void wait_idle();

  int threads() const { return static_cast<int>(thread_count_); }
  std::size_t queued() const;
  std::size_t running() const;
  /// Returns how many jobs currently stand still.
  std::size_t paused() const;
  /// Returns how many jobs have thrown, although they must not.
  std::uint64_t escaped() const { return escaped_; }

  static constexpr std::chrono::milliseconds kAging = FairQueue<int>::kAging;
  /// A task stands still for another client's task if that client has used this much less time. Two such tasks alternate:
  /// each computes for about twice this time.
  static constexpr std::chrono::milliseconds kQuantum{20};
  /// A task that has used less time than this is stopped only for a more urgent task. Otherwise, under overload, the short
  /// computations of many clients would each begin only to stand still for the next one.
  static constexpr std::chrono::milliseconds kShort{30};
  /// Maximum length of one pause in which a job stands still for other jobs of its client.
  static constexpr std::chrono::milliseconds kLongestPause{250};
  /// After such a pause, the job is not asked to stand still again for this long.
  static constexpr std::chrono::milliseconds kLeastWork = kLongestPause / 4;
  /// Maximum number of tasks that have begun, including those that stand still. Other tasks wait until one of them ends.
  static constexpr std::size_t kMostThreads = 128;

 private:
  using Clock = std::chrono::steady_clock;
  struct Task {
    TaskId id;
    double cost;
    Flow flow;
    Clock::time_point arrival;
    Job job;
    Used used;
    Priority origin;      ///< the class in which it was submitted
    bool shared = false;  ///< other clients are also waiting for it
  };
  class Running;
  using Queue = FairQueue<Task>;
  using Client = Queue::Client;

  void work();
  void run(Running& job, int threads);
  bool withdraw(TaskId task, std::optional<Task> (Queue::*remove)(std::uint64_t id));
  // All functions from here on require the lock.
  bool is_idle() const { return running_.empty() && withdrawing_ == 0 && queue_.empty(); }
  std::size_t running_of(Priority priority) const;
  /// Returns how many of the client's running tasks have this class, or began in it and are more urgent now.
  std::size_t places_of(const Client& client, Priority priority) const;
  /// Returns how many jobs compute, in class `least` and in more urgent ones.
  std::size_t computing(Priority least = Priority::kBackground) const;
  bool computes(const Client& client) const;
  bool any_paused() const;
  /// Returns whether the client may begin another job of this class. A client has 3 * threads() places, and the last
  /// threads() of them are for realtime jobs only. In each other class, it may have threads() jobs. A job that is away or
  /// stands still keeps its place.
  bool has_place(const Client& client, Priority priority) const;
  /// Returns whether the task must wait because its account exceeds its processor rate and no other client is waiting for it.
  bool is_held(const Flow& flow, bool shared) const;
  /// Returns whether there is a thread for one more task, after trying to start one if necessary.
  bool has_thread();
  /// Decides which tasks compute, begin and stand still. Must be called after every change.
  void schedule() noexcept;
  void decide();
  void begin(const Queue::Next& next);
  /// Returns how much less time another client must have used before its task displaces this job. The result is in weighted
  /// seconds (FairQueue::cost_of).
  static double quantum(const Running& job);
  /// Returns the seconds that the queued and running tasks of a client and class should still take.
  double left_of(const Client& client, Priority priority) const;
  /// Returns whether this class and more urgent ones have fewer tasks than there are processors.
  bool has_idle_processors(Priority priority) const;
  /// Tells computing jobs whether they should stand still at their next poll.
  void ask(const std::vector<Queue::Next>& fresh, const std::vector<Running*>& paused);
  /// Moves a running task to this class, or to the next one in which its time is not used up.
  void become(Running& job, Priority priority);
  /// Moves running tasks whose time in their class is used up to the next class.
  void end_classes();
  /// Ends tasks of clients that have too many running in a class.
  void thin_out();
  void rest();

  const std::size_t max_queue_;
  const std::array<Clock::duration, 2> longest_;  ///< by Priority
  mutable std::mutex mutex_;
  std::condition_variable wake_, idle_;
  Queue queue_;
  std::map<TaskId, Running*> running_;
  std::deque<std::unique_ptr<Running>> begun_;  ///< wait for their thread to wake up
  TaskId next_ = 1;
  std::size_t withdrawing_ = 0;  ///< tasks that were taken out of the queue and are being released
  std::size_t thread_count_ = 0, free_threads_ = 0;
  double charged_ = 0;    ///< seconds charged since schedule() was last called for them
  bool holds_ = false;    ///< a task waits only because its client exceeds its rate
  bool watches_ = false;  ///< a free thread checks such tasks again soon
  Pace pace_;
  std::atomic<std::uint64_t> escaped_{0};
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace fracture
