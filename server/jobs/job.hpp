// A job as clients see it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "server/service/service.hpp"

namespace fracture {

enum class JobState { kQueued, kRunning, kDone, kFailed, kCancelled };
const char* name_of(JobState state);
/// Returns nothing if no state has this name.
std::optional<JobState> job_state_named(std::string_view name);

/// The state of a job at one moment.
struct JobView {
  std::string id;
  std::string owner;          ///< name that owns the job; may be empty
  std::uint64_t version = 0;  ///< grows with every change
  JobState state = JobState::kQueued;
  std::string stage;     ///< import, prepare, tetrahedralize, clip, encode; empty before the first
  int percent = 0;       ///< 0 to 100; never decreases while the server runs, even if the job restarts
  bool durable = false;  ///< stored on disk, so that it continues after a restart
  /// Time of the request. Unique among all jobs.
  std::chrono::sys_time<std::chrono::microseconds> created{};
  std::optional<std::chrono::sys_time<std::chrono::microseconds>> finished_at{};
  std::optional<std::size_t> queue_position;  ///< number of jobs before it while it is queued
  std::string result_key;                     ///< RequestKeys::result
  /// The result, while it is kept for this job. Null for a job that was done before a restart: its result is
  /// in the disk tier.
  std::shared_ptr<const FractureAnswer> answer;
  std::optional<Error> error;

  bool finished() const { return state != JobState::kQueued && state != JobState::kRunning; }
};

}  // namespace fracture
