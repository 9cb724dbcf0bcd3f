// The threads that compute, and who has them. Three classes: realtime work (a collision) goes before batch work (a
// client waits for the answer), and that before background work (jobs that nobody waits for). Among clients (names,
// addresses) who has used less processor time goes first, whatever the class (fair_queue.hpp says how the two meet).
// Every task says what it should cost. How long a new one would wait follows from the costs that go before it, at the pace
// of their clients (pace.hpp). So a client is refused at once instead of waiting for an answer that comes too late.
//
// This holds while tasks run, and not only when they begin. What a task uses is charged at its polls
// (base/execution.hpp), some hundred times a second. As many tasks compute as was asked for; whoever should compute
// now and does not, because it waits or stands still, takes the place of the task that should the least: that one stands
// still at its next poll. So each task has a thread of its own, because a computation's scratch memory belongs to its
// thread; threads are started when they are needed. If there are two processors or more, realtime work need not even wait
// for the poll: when tasks compute on all of them, one more is begun at once, and whoever polls first makes room.
//
// Nobody stands still for ever. Other clients use up their turn. And whoever stood still for kLongestPause while another
// task of its client computes goes on for a quarter of that, one task at a time beyond those that there are processors
// for. So nothing that it holds (a value that others wait for) is held for ever, and within a client each class gets its
// part of the time even if more urgent work never ends.
//
// A client that is over its processor rate (tenants/account.hpp) computes nothing until it is within it again, except what
// others wait for, too.
//
// A task that runs may change its class, and those who hurry it by turns may do so for ever. So it is of a class for a
// limited time in all (Longest), and of the next one from then on. As many tasks of a client begin in a class as there
// are processors, and each keeps its place there while it is more urgent. So where too many run, it is those who began
// in a more urgent class: they end at their next poll (kOverloaded), or they would keep threads for as long as they take.
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

/// For how long a task that runs is realtime, or batch work, in all: nobody waits longer in that class.
struct Longest {
  std::chrono::milliseconds realtime{2'000}, batch{60'000};
};

struct Execution;

class WorkerPool {
 public:
  /// A job is told how many threads it may use for its own loops: the pool's threads divided among the jobs
  /// that run, so that a lone request uses every core and a loaded server runs one job a core.
  using Job = std::function<void(int threads)>;
  /// Told on the job's thread, at some of its polls and at its end, how many seconds it has used since it was told
  /// before. Charges whoever it is for.
  using Used = std::function<void(double seconds)>;
  using TaskId = std::uint64_t;

  /// `threads`: jobs that compute at the same time.
  WorkerPool(int threads, std::size_t max_queue, const Longest& longest = {});
  /// Finishes what is queued (cancel it through its own stop tokens first when that would take too long).
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// The id of the task; never refused (look at full() and predicted_wait() first). `cost`: what the job
  /// should take, in seconds of one thread of a machine of nominal speed; measured() says how far off such
  /// estimates are. `used`: empty, the flow is charged. Jobs must not throw.
  TaskId submit(Priority priority, double cost, Job job, const Flow& flow = {}, Used used = {});
  /// Work that was admitted before and goes on: never refused, and every other task of its client and class that begins
  /// is such a one while any wait. `cost`: what is left of it; `origin`: the class in which it was submitted.
  TaskId resume(Job job, Priority priority = Priority::kRealtime, double cost = 0,
                std::optional<Priority> origin = std::nullopt, const Flow& flow = {}, Used used = {});
  /// A task is of this class from now on, queued or running, or of the most urgent one that is left to it (Longest).
  /// Nothing happens when it is neither, or of that class already. True: it is queued, and takes the turn of this flow
  /// there instead of the one that it had.
  bool reclassify(TaskId task, Priority priority, const Flow& flow = {});
  /// Another client waits for the task, too, in the same class. True: it is queued, and takes the turn of this flow, because
  /// that comes sooner.
  bool hasten(TaskId task, const Flow& flow);
  /// Another client waits for the task, too: that the first one is over its processor rate holds it up no longer.
  void share(TaskId task);
  /// A task that is queued does not run. False where it is not: it has begun, or was resumed.
  bool withdraw(TaskId task);
  /// The same for a task that was resumed. The caller must end the work that the task was to continue.
  bool withdraw_resumed(TaskId task);
  /// A background task that runs ends at its next poll (kOverloaded): more urgent ones need what it holds. False where it
  /// does not run, or is more urgent.
  bool give_up(TaskId task);
  /// So many seconds were used for a flow, and its account.
  void charge(Priority priority, const Flow& flow, double seconds);

  /// Of the job that the calling thread runs, for its Execution; null on other threads.
  static Turn* turn();
  /// What the job that the calling thread runs has used is charged by now.
  static void charge_by_now();
  /// The job that the calling thread runs stands still no longer when this is stopped or past its deadline: its poll says so.
  static void stands_still_while_wanted(const Execution& execution);
  /// The job that the calling thread runs should stand still at its next poll, or does.
  static bool stands_back();
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
  static constexpr std::size_t kMostPlaced = 1000;

  /// This flow has as many tasks waiting as it may: max_queue if no other waits, else its part of twice as many
  /// (FairShare). A first one is taken up to four times as many, so that there is room for whoever comes next. Background tasks are counted for themselves: they may wait for
  /// long, and nobody else is turned away for them.
  bool full(Priority priority, const Flow& flow = {}) const;

  /// How long a new job of this class, flow and cost would be queued or stand still: what is computed before its end, at the
  /// pace of each client that was measured so far.
  std::chrono::duration<double> predicted_wait(Priority priority, const Flow& flow = {},
                                               double cost = 0) const;
  /// How long all work of this class and of more urgent ones that has come would take: for whoever has used more than
  /// everybody else, and so for the need of further servers.
  std::chrono::duration<double> backlog(Priority priority) const;
  /// The seconds that a job of this client and cost should take, by the same measure.
  std::chrono::duration<double> predicted_run(const std::string& client, double cost) const;

  /// Work of this client and cost took so many seconds of one thread, over all the jobs it was divided into.
  void measured(const std::string& client, double cost, double seconds);

  /// Returns when nothing is queued and nothing runs.
  void wait_idle();

  int threads() const { return static_cast<int>(thread_count_); }
  std::size_t queued() const;
  std::size_t running() const;
  /// Jobs that stand still for more urgent ones, now.
  std::size_t paused() const;
  /// Jobs that threw, though they must not.
  std::uint64_t escaped() const { return escaped_; }

  static constexpr std::chrono::milliseconds kAging = FairQueue<int>::kAging;
  /// A task stands still for one of a client that has used so much less; each computes for about twice that before
  /// it is the other's turn.
  static constexpr std::chrono::milliseconds kQuantum{20};
  /// But what takes no longer than this ends first, unless another client's is more urgent: so that when many clients ask for
  /// more than there is, each of their short computations is not begun only to stand still for the next one.
  static constexpr std::chrono::milliseconds kShort{30};
  /// A job stands still for others of its client for at most this long at once ...
  static constexpr std::chrono::milliseconds kLongestPause{250};
  /// ... and then not again for so long.
  static constexpr std::chrono::milliseconds kLeastWork = kLongestPause / 4;
  /// Tasks that have begun, those that stand still included. Beyond that, clients wait for one of them to end.
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
    bool shared = false;  ///< others wait for it, too
  };
  class Running;
  using Queue = FairQueue<Task>;
  using Client = Queue::Client;

  void work();
  void run(Running& job, int threads);
  bool withdraw(TaskId task, std::optional<Task> (Queue::*remove)(std::uint64_t id));
  // All of these with the lock.
  bool is_idle() const { return running_.empty() && withdrawing_ == 0 && queue_.empty(); }
  std::size_t running_of(Priority priority) const;
  /// Of a client which run and are of this class, or began there and are more urgent now.
  std::size_t places_of(const Client& client, Priority priority) const;
  /// Jobs that compute, of this class and more urgent ones.
  std::size_t computing(Priority least = Priority::kBackground) const;
  bool computes(const Client& client) const;
  bool any_paused() const;
  /// A client may have as many jobs of each class as may compute, the last of them are for realtime jobs alone; who is
  /// away or stands still keeps its place.
  bool has_place(const Client& client, Priority priority) const;
  /// Its account is over its rate, and nobody else waits for it.
  bool is_held(const Flow& flow, bool shared) const;
  /// There is a thread for one more, or one can be started.
  bool has_thread();
  /// Who computes, begins and stands still, as things are. After every change.
  void schedule() noexcept;
  void decide();
  void begin(const Queue::Next& next);
  /// How much less another client must have used, in what that counts as.
  static double quantum(const Running& job);
  /// Seconds that the tasks of a client and class should still take, queued ones included.
  double left_of(const Client& client, Priority priority) const;
  /// Fewer tasks of this class and of more urgent ones than there are processors.
  bool has_idle_processors(Priority priority) const;
  /// Tells those who compute whether they should stand still at their next poll.
  void ask(const std::vector<Queue::Next>& fresh, const std::vector<Running*>& paused);
  /// A task that runs is of this class from now on, or of the one that is left to it.
  void become(Running& job, Priority priority);
  /// Those that were of their class for long enough are so no longer.
  void end_classes();
  /// Those end that are too many.
  void thin_out();
  void rest();

  const std::size_t max_queue_;
  const std::array<Clock::duration, 2> longest_;  ///< by Priority
  mutable std::mutex mutex_;
  std::condition_variable wake_, idle_;
  Queue queue_;
  std::map<TaskId, Running*> running_;
  std::deque<std::unique_ptr<Running>> begun_;  ///< that wait for their thread to wake
  TaskId next_ = 1;
  std::size_t withdrawing_ = 0;  ///< tasks that were taken out of the queue and are being released
  std::size_t thread_count_ = 0, free_threads_ = 0;
  double charged_ = 0;    ///< seconds since that was looked at
  bool holds_ = false;    ///< something waits only because its client is over its rate ...
  bool watches_ = false;  ///< ... and a free thread looks again soon
  Pace pace_;
  std::atomic<std::uint64_t> escaped_{0};
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace fracture
