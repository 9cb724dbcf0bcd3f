// Fractures that nobody waits for on a connection: started, watched, cancelled, fetched later. A job is one
// more waiter of the dispatcher, so that it shares its computation with whoever asks for the same.
//
//   start ──> queued ──> running ──> done | failed | cancelled ──ttl──> forgotten
//     │                     │
//     └─ on the disk ───────┴─ the server ends ──> queued again, by the next server on the same folder
//
// Where there is a folder (job_folder.hpp), mesh and request are on the disk before the job is accepted.
// Everything that touches the disk happens on threads of its own (disk_work.hpp), in order for each client,
// but for the mark that a job has begun (JobFolder::begun), which its computing thread leaves.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <unordered_map>
#include <vector>

#include <tl/expected.hpp>

#include "server/jobs/disk_work.hpp"
#include "server/jobs/job.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/service/dispatcher.hpp"

namespace fracture {

struct JobsConfig {
  std::size_t max_jobs = 1000;                    ///< known at the same time, finished ones included
  std::uint64_t max_result_bytes = 512ull << 20;  ///< of results that are kept for their jobs
  std::chrono::milliseconds ttl{600'000};         ///< a finished job is forgotten after this
  /// From the moment a job is asked for, or first goes on after a restart, to its end, whether it computes or
  /// waits.
  std::chrono::milliseconds deadline{1'800'000};
  std::string folder;                         ///< of what survives the process; empty: nothing does
  std::uint64_t max_disk_bytes = 1ull << 30;  ///< of that folder
  FarmKeys keys{};                            ///< sign what is in that folder
};

struct JobFigures {
  std::uint64_t started = 0, expired = 0, evicted = 0, resumed = 0;
  std::uint64_t results_evicted = 0;  ///< of jobs that are known all the same
  std::size_t jobs = 0, unfinished = 0;
  std::size_t waiting = 0;  ///< of the unfinished: on the disk, and not being computed
  std::size_t durable = 0;  ///< of the unfinished: those on the disk
  std::uint64_t result_bytes = 0;
};

/// Thread-safe. A job counts as its holder's, the client that pays for it, whoever may see it. A holder that wants more
/// than there is room for gives up its own, and never takes what others have that have no more.
class Jobs {
 public:
  /// Learns what the folder has, unless another server has the folder. Nothing of that is computed before resume().
  Jobs(Dispatcher& dispatcher, const JobsConfig& config);
  ~Jobs();
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  /// Whose it is, and how much of the folder its owner may have.
  struct Owner {
    std::string name{};
    std::uint64_t share = UINT64_MAX;  ///< bytes
  };
  /// `accepted` is called once with the job as it is by then (it may even be done and forgotten), when it is
  /// on the disk where it can be: now, or later from any thread. Its id: the first 16 hex digits of the mesh
  /// digest (for routing by proxies), a hyphen, 16 random ones. `terms.gone` and `terms.progress` are the
  /// job's own. Refused: `accepted` is dropped uncalled.
  std::optional<Error> start(FractureRequest request, Terms terms, const Owner& owner,
                             std::function<void(const JobView&)> accepted);

  /// What belongs to the jobs of an owner: whom they are charged to, who is told of their answers.
  using TermsOf = std::function<Terms(const std::string& owner)>;
  /// From now on what the folder had is computed, little by little. `terms_of` is called from any thread, and
  /// not any more after stop(). `known` is told of each that was done before, now or by take_folder(): its owner may see
  /// the result.
  void resume(TermsOf terms_of, std::function<void(const JobView&)> known);

  /// What of that has not begun stays as it is.
  void stop_resuming();

  /// Takes the folder when the other server has let it go: from then on its jobs are known here, and go on. False while
  /// it has not, and until the disk tier has its folder (ResultTiers::take_folder). By one thread at a time.
  Expected<bool> take_folder();
  /// Another server has the folder: what is asked about its jobs cannot be said here.
  bool waits_for_folder() const { return folder_ && !folder_ready_; }

  /// Nothing when it is not known (any more).
  std::optional<JobView> find(const std::string& id);
  struct Filter {
    std::function<bool(const std::string& owner)> sees;  ///< empty: every owner's
    std::optional<JobState> state{};
    /// Only jobs that were created before this.
    std::chrono::sys_time<std::chrono::microseconds> before =
        std::chrono::sys_time<std::chrono::microseconds>::max();
  };
  /// The newest first, `limit` at most.
  std::vector<JobView> list(const Filter& filter, std::size_t limit);

  using WatchId = std::uint64_t;
  /// Calls `changed` once, with the first state whose version is over `seen`: now (then the id is 0), or
  /// later from any thread. Nothing when the job is not known.
  std::optional<WatchId> watch(const std::string& id, std::uint64_t seen,
                               std::function<void(const JobView&)> changed);
  /// Drops it uncalled, unless it has been or is being called.
  void unwatch(const std::string& id, WatchId watch);
  /// Stops an unfinished job and forgets a finished one. False when it is not known.
  bool cancel(const std::string& id);
  /// A result that is kept for a job, by its key; null when there is none.
  std::shared_ptr<const FractureResult> find_result(const std::string& key);

  /// Forgets what has expired, and tries again what could not be resumed.
  void sweep();
  /// The end: no further job is taken; unfinished ones stop. Those on the disk stay there, as if they had
  /// never begun; the others are cancelled. Returns at once.
  void stop();
  /// Drops everybody who watches, uncalled.
  void drop_watchers();
  /// Returns when everything that has happened so far is on the disk, and what waited and could begin has
  /// been submitted.
  void flush();

  JobFigures figures() const;
  /// Nothing: there is no folder, or it is not ours (folder_unusable() and waits_for_folder() say why).
  std::optional<JobFolderFigures> disk_figures() const;
  std::uint64_t disk_bytes_of(const std::string& owner) const;
  const std::optional<Error>& folder_unusable() const { return folder_unusable_; }
  const JobsConfig& config() const { return config_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Watcher {
    WatchId id;
    std::function<void(const JobView&)> changed;
  };
  struct Job {
    JobView view;
    std::string client{};  ///< whose turn its work for the disk takes, from its first to its last
    std::string holder{};  ///< whose it counts as: the flow that pays for it
    /// What of it is or would be on the disk, but for its parameters: they may be a megabyte, and nobody pays for
    /// a job's share of the memory. They are in `request`, or on the disk.
    JobRecord record;
    std::stop_source stop;
    int clip_begins = 0;  ///< of its percent
    std::vector<Watcher> watchers;
    Clock::time_point finished = Clock::time_point::max();
    std::uint64_t begun = 0;          ///< processes that ended while they computed it
    std::uint64_t resumed_bytes = 0;  ///< of its mesh, read from the disk
    bool kept = false;                ///< the folder has a place for it
    bool written_end = false;  ///< what it came to is on the disk; known to the work for the disk alone
    bool marked = false;       ///< the folder has this process's mark that it was begun
    bool waiting = false;      ///< for pump(): from an earlier process, or crowded out of memory in this one
    bool computing = false;    ///< submitted by pump()
    /// What it is computed from, where that is not on the disk; with it the memory that it has taken already.
    std::optional<FractureRequest> request;
    std::optional<Terms> terms;  ///< with which it was submitted in this process; nothing: never yet
    /// Runs from its first attempt in this process on, whether it computes or waits.
    std::optional<Clock::time_point> deadline;
    std::uint64_t refused_in = 0;   ///< the last pass of pump() that could not begin it
    std::uint64_t least_bytes = 0;  ///< of working memory: set when it was crowded out
    bool suspended = false;         ///< stopped by stop(), to go on later
  };
  /// What one holder has.
  struct Held {
    std::size_t jobs = 0, unfinished = 0;
    std::uint64_t result_bytes = 0;
  };
  class Counted;
  using Shared = std::shared_ptr<Job>;
  using Calls = std::vector<std::function<void()>>;

  Shared get(const std::string& id);
  /// Takes the lock.
  JobView look_at(const Job& job);
  /// Says of those that are queued how many go before them. Without the lock.
  void place(std::vector<JobView>& views);
  /// What start() does once the job has its place.
  std::optional<Error> begin(const Shared& job, FractureRequest request, Terms terms, const Owner& owner,
                             std::function<void(const JobView&)> accepted);
  std::optional<Error> submit(const Shared& job, FractureRequest request, Terms terms);
  void progress(const Shared& job, Stage stage, double fraction);
  /// Leaves the mark on the disk. Whoever finds `marked` takes it back.
  void mark_begun(const Shared& job);
  void finish(const Shared& job, Expected<FractureAnswer> answer);
  /// Writes the job's mesh and request. As work for the disk.
  void persist(const Shared& job, const FractureRequest& request);
  /// What it wrote, or could not write, is gone; the job is computed all the same. As work for the disk.
  void not_durable(const Shared& job);
  /// Writes what the job came to. As work for the disk.
  void persist_end(const Shared& job, const std::shared_ptr<const FractureAnswer>& answer);
  bool write_end(const Shared& job, const JobRecord& record,
                 const std::shared_ptr<const FractureAnswer>& answer);
  /// Submits what can be of those that wait. As work for the disk.
  void pump();
  void pump_later();
  /// An error: it is refused now, and waits on.
  std::optional<Error> resume_one(const Shared& job);
  /// Would the dispatcher refuse it whatever its mesh? Asked before that is read, for who is refused is tried
  /// again often. Takes its place among the computations of its name.
  std::optional<Error> refuses(Terms& terms);
  void restore();
  /// Lets restored jobs begin, and tells of those that were done.
  void go_on();
  std::optional<Error> room_for(const Shared& job, const JobRecord& record, std::uint64_t share);
  // All of these with the lock.
  Calls change(const Shared& job);
  void ended(const Shared& job);
  /// No failure of its own ended it: stop() did, and the next process goes on; or others held the memory that
  /// it turned out to need, and it waits until as much is free, or for the next process (stop_resuming).
  bool begins_again(const Shared& job, const Error& error);
  /// Of those that wait fails whose deadline has passed and who were cancelled.
  Calls end_waits();
  /// Null: nobody may begin now. Not of those payers, and who was refused in this pass is not tried again.
  Shared next_to_submit(const std::set<std::string>& over_share);
  bool can_be_submitted(const Job& job) const { return job.waiting && (job.request || terms_of_); }
  void fail_locked(const Shared& job, Error error);
  void forget(std::list<Shared>::iterator at);
  void make_room();
  /// A place for one more job of this holder, or why there is none.
  std::optional<Error> make_place_for(const std::string& holder);
  /// Of this holder the oldest that is finished, or has a result.
  std::list<Shared>::iterator oldest_of(const std::string& holder, bool (*wanted)(const Job&));
  /// In the order of their creation.
  void insert(const Shared& job);
  void count(const Job& job, bool held);
  void hand_over(Job& job, const std::string& holder);

  Dispatcher& dispatcher_;
  const JobsConfig config_;
  std::optional<Error> folder_unusable_;
  std::unique_ptr<JobFolder> folder_;
  std::atomic<bool> folder_ready_{false};  ///< what it had is known; from then on it is written to
  mutable std::mutex mutex_;
  std::list<Shared> jobs_;  // oldest first
  std::unordered_map<std::string, std::list<Shared>::iterator> index_;
  std::map<std::string, Held> held_;  // by holder; none without jobs
  JobFigures figures_;
  WatchId next_watch_ = 1;
  std::chrono::sys_time<std::chrono::microseconds> last_created_{};
  TermsOf terms_of_;
  std::function<void(const JobView&)> known_;  ///< see resume()
  bool stopping_ = false;
  bool pump_queued_ = false;
  std::uint64_t pass_ = 0;  ///< of pump()
  DiskWork disk_;           // last: it uses everything above
};

/// While a job that is known changes, it is not counted.
class Jobs::Counted {
 public:
  Counted(Jobs& jobs, const Job& job) : jobs_(jobs), job_(job), known_(jobs.index_.contains(job.view.id)) {
    if (known_) jobs_.count(job_, false);
  }
  ~Counted() {
    if (known_) jobs_.count(job_, true);
  }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  Jobs& jobs_;
  const Job& job_;
  const bool known_;
};

}  // namespace fracture
