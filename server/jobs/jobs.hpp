// Fractures that run without a waiting connection: they are started, watched, cancelled, and fetched later. A
// job is an ordinary waiter of the dispatcher, so it shares its computation with other requests for the same
// result.
//
//   start ──> queued ──> running ──> done | failed | cancelled ──ttl──> forgotten
//     │                     │
//     └─ on the disk ───────┴─ the server ends ──> queued again, by the next server on the same folder
//
// If there is a folder (job_folder.hpp), the mesh and the request are on disk before the job is accepted. All
// disk operations run on their own threads (disk_work.hpp), in order for each client. The exception is the
// mark that a job has begun (JobFolder::begun), which is written by the computing thread.
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
  std::size_t max_jobs = 1000;                    ///< jobs known at the same time, including finished ones
  std::uint64_t max_result_bytes = 512ull << 20;  ///< for results that are kept for jobs
  std::chrono::milliseconds ttl{600'000};         ///< time after which a finished job is forgotten
  /// Maximum time from the request for a job to its end, whether it computes or waits. After a restart, the
  /// time starts again when the job first resumes.
  std::chrono::milliseconds deadline{1'800'000};
  std::string folder;                         ///< where jobs survive the process; empty: nowhere
  std::uint64_t max_disk_bytes = 1ull << 30;  ///< of that folder
  FarmKeys keys{};                            ///< to sign the records in that folder
  std::function<void()> before_mark{};  ///< called before a job's mark is written; tests stop the job there
};

struct JobFigures {
  std::uint64_t started = 0, expired = 0, evicted = 0, resumed = 0;
  std::uint64_t results_evicted = 0;  ///< results dropped although their jobs are still known
  std::size_t jobs = 0, unfinished = 0;
  std::size_t waiting = 0;  ///< unfinished jobs that are on disk and not being computed
  std::size_t durable = 0;  ///< unfinished jobs that are on disk
  std::uint64_t result_bytes = 0;
  std::uint64_t pinned_bytes = 0;  ///< results in the disk tier that are not evicted (ResultTiers::pin)
};

/// Thread-safe. A job is charged to its holder, the client that pays for it, whoever may see it. If a holder
/// exceeds the available room, its own jobs make way; jobs of holders with no more jobs than it are never
/// removed.
class Jobs {
 public:
  /// Loads the jobs from the folder, unless another server holds the folder. They are not computed before
  /// resume().
  Jobs(Dispatcher& dispatcher, const JobsConfig& config);
  ~Jobs();
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  /// The owner of a job, and how much of the folder its jobs may use.
  struct Owner {
    std::string name{};
    std::uint64_t share = UINT64_MAX;  ///< bytes
  };
  /// Starts a job. `accepted` is called once, now or later from any thread, when the job is on disk if it can
  /// be stored. It receives the job's current state; the job may even be done and forgotten by then. The id
  /// is the first 16 hex digits of the mesh digest (for routing by proxies), a hyphen, and 16 random digits.
  /// `terms.gone` and `terms.progress` are replaced. If the job is refused, `accepted` is not called.
  std::optional<Error> start(FractureRequest request, Terms terms, const Owner& owner,
                             std::function<void(const JobView&)> accepted);

  /// Returns the terms for an owner's jobs: the account that pays, and the receiver of their answers. Without an
  /// account, a job is charged to the client in its record. If the record has none either, the returned flow
  /// pays.
  using TermsOf = std::function<Terms(const std::string& owner)>;
  /// Starts computing the jobs from the folder, a few at a time. `terms_of` is called from any thread, but
  /// not after stop(). `known` is called for each job that was already done, now or in take_folder(), because
  /// its owner may see the result.
  void resume(TermsOf terms_of, std::function<void(const JobView&)> known);

  /// Leaves restored jobs that have not begun for the next process.
  void stop_resuming();

  /// Takes over the folder once the other server has released it. Its jobs are then known here and continue.
  /// Returns false while that server holds it, and until the disk tier has its folder
  /// (ResultTiers::take_folder). Call from one thread at a time.
  Expected<bool> take_folder();
  /// Returns whether another server holds the folder. Until it is released, its jobs are unknown here.
  bool waits_for_folder() const { return folder_ && !folder_ready_; }

  /// Returns nothing if the job is not known (any more).
  std::optional<JobView> find(const std::string& id);
  struct Filter {
    std::function<bool(const std::string& owner)> sees;  ///< empty: jobs of all owners
    std::optional<JobState> state{};
    /// Only jobs created before this time.
    std::chrono::sys_time<std::chrono::microseconds> before =
        std::chrono::sys_time<std::chrono::microseconds>::max();
  };
  /// Returns at most `limit` jobs, newest first.
  std::vector<JobView> list(const Filter& filter, std::size_t limit);

  using WatchId = std::uint64_t;
  /// Calls `changed` once, with the first state whose version is greater than `seen`: now (the returned id is
  /// then 0), or later from any thread. Returns nothing if the job is not known.
  std::optional<WatchId> watch(const std::string& id, std::uint64_t seen,
                               std::function<void(const JobView&)> changed);
  /// Removes a watch without calling it. A call that is in progress is not affected.
  void unwatch(const std::string& id, WatchId watch);
  /// Stops an unfinished job or forgets a finished one. Returns false if the job is not known.
  bool cancel(const std::string& id);
  /// Returns a result that is kept for a job, by its key, or null.
  std::shared_ptr<const FractureResult> find_result(const std::string& key);
  /// Returns whether this owner has a done job with this result. The owner may then fetch it.
  bool has_result(const std::string& owner, const std::string& key);
  /// Returns whether the result is that of a done job, or will be that of an unfinished one, whoever owns it.
  bool needs_result(const std::string& key);
  /// For a result that was not found. Returns kJobLost if a job with an owner for whom `sees` is true has promised
  /// it. `nowhere`: all tiers were read, and none has it.
  std::optional<Error> lost_result(const std::string& key,
                                   const std::function<bool(const std::string& owner)>& sees, bool nowhere);

  /// Forgets expired jobs and retries those that could not be resumed.
  void sweep();
  /// Stops everything: no further job is accepted, and unfinished ones stop. Jobs on disk stay there as if
  /// they had never begun; the others are cancelled. Returns at once.
  void stop();
  /// Removes all watches without calling them.
  void drop_watchers();
  /// Returns when everything that has happened so far is on disk, and waiting jobs that could begin have been
  /// submitted.
  void flush();

  JobFigures figures() const;
  /// Returns nothing if there is no folder or it is not ours; folder_unusable() and waits_for_folder() say
  /// why.
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
  struct Job;
  using Shared = std::shared_ptr<Job>;
  using ByResult = std::multimap<std::string, Shared>;
  struct Job {
    JobView view;
    ByResult::iterator by_result{};  ///< while it is known
    std::string client{};            ///< the client in DiskWork under which all its disk work runs
    std::string holder{};            ///< the flow that pays for it
    /// The record that is or would be on disk, but without the parameters. Those can be a megabyte, and the
    /// memory for them is not charged to the job. They are in `request` or on disk.
    JobRecord record;
    std::stop_source stop;
    int clip_begins = 0;  ///< percent at which clip begins
    std::vector<Watcher> watchers;
    Clock::time_point finished = Clock::time_point::max();
    std::uint64_t begun = 0;          ///< number of processes that ended while they computed it
    std::uint64_t resumed_bytes = 0;  ///< of its mesh, read from disk
    bool kept = false;                ///< has a place in the folder
    bool written_end = false;         ///< the outcome is on disk; used only by disk work
    bool writes_end = false;  ///< the outcome will be written; until then, the disk work has the result
    std::weak_ptr<const FractureAnswer> being_written;  ///< the answer that the disk work has
    bool marked = false;                                ///< the folder has this process's mark
    bool waiting = false;    ///< for pump(): from an earlier process, or stopped for lack of memory
    bool computing = false;  ///< submitted by pump()
    /// The request while it is not on disk, together with the memory that it has reserved.
    std::optional<FractureRequest> request;
    std::optional<Terms> terms;  ///< terms of its last submission in this process; empty: not submitted
    /// Counted from the first attempt in this process, whether the job computes or waits.
    std::optional<Clock::time_point> deadline;
    std::uint64_t refused_in = 0;    ///< last pass of pump() in which it was refused
    std::uint64_t least_bytes = 0;   ///< working memory that it needs; set when it ran out of memory
    bool suspended = false;          ///< stopped by stop(), to continue later
    std::uint64_t pinned_bytes = 0;  ///< of its result in the disk tier; 0: not pinned
  };
  /// Counts of one holder.
  struct Held {
    std::size_t jobs = 0, unfinished = 0;
    std::uint64_t result_bytes = 0, pinned_bytes = 0;
  };
  class Counted;
  using Calls = std::vector<std::function<void()>>;

  Shared get(const std::string& id);
  /// Acquires the lock. Checks the job's result (check_result).
  JobView look_at(const Shared& job);
  /// Fails a done job whose result has left memory and is in no tier. Call without the lock, because the disk
  /// tier may make this thread wait.
  /// Returns whether it has just failed the job.
  bool check_result(const Shared& job);
  /// Fills in the queue positions of queued jobs. Call without the lock.
  void place(std::vector<JobView>& views);
  /// The part of start() after the job was inserted.
  std::optional<Error> begin(const Shared& job, FractureRequest request, Terms terms, const Owner& owner,
                             std::function<void(const JobView&)> accepted);
  std::optional<Error> submit(const Shared& job, FractureRequest request, Terms terms);
  void progress(const Shared& job, Stage stage, double fraction);
  /// Writes the mark to disk. Code that resets `marked` must also remove the mark.
  void mark_begun(const Shared& job);
  void finish(const Shared& job, Expected<FractureAnswer> answer);
  /// Writes the job's mesh and request. Runs as disk work.
  void persist(const Shared& job, const FractureRequest& request);
  /// Removes the job from the folder after writing failed; the job is computed anyway. Runs as disk work.
  void not_durable(const Shared& job);
  /// Writes the outcome of the job. Runs as disk work.
  void persist_end(const Shared& job, const std::shared_ptr<const FractureAnswer>& answer);
  bool write_end(const Shared& job, const JobRecord& record,
                 const std::shared_ptr<const FractureAnswer>& answer);
  /// Writes the result to the disk tier and pins it there, if the holder's part allows. Returns false if it
  /// is not there.
  bool keep_result(const Shared& job, const std::shared_ptr<const FractureResult>& result);
  /// Submits as many waiting jobs as possible. Runs as disk work.
  void pump();
  void pump_later();
  /// Returns an error if the job is refused now; it then continues to wait.
  std::optional<Error> resume_one(const Shared& job);
  /// Returns an error if the dispatcher would refuse the job whatever its mesh. Called before the mesh is
  /// read, because refused jobs are retried often. Takes a seat among the computations of the job's name.
  std::optional<Error> refuses(Terms& terms);
  void restore();
  /// Lets restored jobs begin, and reports those that were already done.
  void go_on();
  std::optional<Error> room_for(const Shared& job, const JobRecord& record, std::uint64_t share);
  // The following functions need the lock.
  Calls change(const Shared& job);
  void ended(const Shared& job);
  /// Returns whether the job runs again, because it did not fail by itself. Either stop() interrupted it, and
  /// the next process continues it. Or other work held the memory that it needs, and it waits for memory or
  /// for the next process (stop_resuming).
  bool begins_again(const Shared& job, const Error& error);
  /// Fails waiting jobs that were cancelled or whose deadline has passed.
  Calls end_waits();
  /// Returns null if no job may begin now. Skips the holders in `over_share`, and jobs refused in this pass.
  Shared next_to_submit(const std::set<std::string>& over_share);
  bool can_be_submitted(const Job& job) const { return job.waiting && (job.request || terms_of_); }
  void fail_locked(const Shared& job, Error error);
  void forget(std::list<Shared>::iterator at);
  void make_room();
  /// Charges the pin of a done job to its holder. While the pins exceed their limit, the holder with the most
  /// bytes loses its oldest pin. Returns false if this job may not have one; the caller then removes it.
  bool charge_pin(Job& job, std::uint64_t bytes);
  /// Does nothing if the job has no pin.
  void unpin(Job& job);
  /// Makes room for one more job of this holder, or returns an error.
  std::optional<Error> make_place_for(const std::string& holder);
  /// Returns this holder's oldest job for which `wanted` is true.
  std::list<Shared>::iterator oldest_of(const std::string& holder, bool (*wanted)(const Job&));
  /// Returns that job of the holder with the largest sum.
  Job& oldest_of_most(std::uint64_t Held::*sum, bool (*wanted)(const Job&));
  /// Returns whether the job is done and does not hold its result in memory or in the write to the disk.
  static bool let_result_go(const Job& job);
  /// Inserts the job in order of creation.
  void insert(const Shared& job);
  /// Changes the key of the job's result.
  void set_result_key(Job& job, const std::string& key);
  void count(const Job& job, bool held);
  void hand_over(Job& job, const std::string& holder);

  Dispatcher& dispatcher_;
  const JobsConfig config_;
  std::optional<Error> folder_unusable_;
  std::unique_ptr<JobFolder> folder_;
  std::atomic<bool> folder_ready_{false};  ///< its jobs are known, and new ones are written to it
  mutable std::mutex mutex_;
  std::list<Shared> jobs_;  // oldest first
  std::unordered_map<std::string, std::list<Shared>::iterator> index_;
  ByResult by_result_;                // by JobView::result_key
  std::map<std::string, Held> held_;  // by holder; only holders with jobs
  JobFigures figures_;
  WatchId next_watch_ = 1;
  std::chrono::sys_time<std::chrono::microseconds> last_created_{};
  TermsOf terms_of_;
  std::function<void(const JobView&)> known_;  ///< see resume()
  bool stopping_ = false;
  bool pump_queued_ = false;
  std::uint64_t pass_ = 0;  ///< number of pump() passes
  DiskWork disk_;           // last, because it uses everything above
};

/// Removes a known job from the counts while it changes, and adds it again afterwards.
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
