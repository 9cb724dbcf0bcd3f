// Fractures that nobody waits for on a connection: started, watched, cancelled, fetched later. A job is one
// more waiter of the dispatcher, so that it shares its computation with whoever asks for the same.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <unordered_map>
#include <vector>

#include <tl/expected.hpp>

#include "server/service/dispatcher.hpp"

namespace fracture {

struct JobsConfig {
  std::size_t max_jobs = 1000;                    ///< known at the same time, finished ones included
  std::uint64_t max_result_bytes = 512ull << 20;  ///< of results that are kept for their jobs
  std::chrono::milliseconds ttl{600'000};         ///< a finished job is forgotten after this
};

enum class JobState { kQueued, kRunning, kDone, kFailed, kCancelled };
const char* name_of(JobState state);

/// A job at one moment.
struct JobView {
  std::string id;
  std::string owner;          ///< whose it is; may be empty
  std::uint64_t version = 0;  ///< grows with every change
  JobState state = JobState::kQueued;
  std::string stage;  ///< import, prepare, tetrahedralize, clip, encode; empty before the first
  int percent = 0;    ///< 0 to 100, never falls
  std::optional<std::size_t> queue_position;  ///< how many go before it, while it is queued
  std::shared_ptr<const FractureResult> result;
  std::optional<Error> error;

  bool finished() const { return state != JobState::kQueued && state != JobState::kRunning; }
};

struct JobFigures {
  std::uint64_t started = 0, expired = 0, evicted = 0;
  std::size_t jobs = 0, unfinished = 0;
  std::uint64_t result_bytes = 0;
};

/// Thread-safe.
class Jobs {
 public:
  Jobs(Dispatcher& dispatcher, const JobsConfig& config) : dispatcher_(dispatcher), config_(config) {}

  /// The new job as it is by now (it may even be done and forgotten). Its id: the first 16 hex digits of the
  /// mesh digest (for routing by proxies), a hyphen, 16 random ones. `terms.gone` and `terms.progress` are
  /// the job's own.
  tl::expected<JobView, Overload> start(FractureRequest request, Terms terms, const std::string& owner = "");

  /// Nothing when it is not known (any more).
  std::optional<JobView> find(const std::string& id);
  /// Calls `changed` once, with the first state whose version is over `seen`: now, or later from any thread.
  /// False when the job is not known.
  bool watch(const std::string& id, std::uint64_t seen, std::function<void(const JobView&)> changed);
  /// Stops an unfinished job and forgets a finished one. False when it is not known.
  bool cancel(const std::string& id);
  /// A result that is kept for a job, by its key; null when there is none.
  std::shared_ptr<const FractureResult> find_result(const std::string& key);

  /// Forgets what has expired.
  void sweep();
  /// Stops all unfinished jobs.
  void cancel_all();
  /// Drops everybody who watches, uncalled.
  void drop_watchers();

  JobFigures figures() const;
  const JobsConfig& config() const { return config_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    JobView view;
    std::string result_key;
    std::stop_source stop;
    std::vector<std::pair<std::uint64_t, std::function<void(const JobView&)>>> watchers;
    Clock::time_point finished = Clock::time_point::max();
  };
  using Shared = std::shared_ptr<Job>;

  Shared get(const std::string& id);
  /// Takes the lock.
  JobView look_at(const Job& job);
  void progress(const Shared& job, const char* stage, double fraction);
  void finish(const Shared& job, Expected<FractureAnswer> answer);
  /// With the lock; returns the calls to make without it.
  std::vector<std::function<void()>> change(const Shared& job);
  void forget(std::list<Shared>::iterator at);
  void make_room();

  Dispatcher& dispatcher_;
  const JobsConfig config_;
  mutable std::mutex mutex_;
  std::list<Shared> jobs_;  // oldest first
  std::unordered_map<std::string, std::list<Shared>::iterator> index_;
  JobFigures figures_;
};

}  // namespace fracture
