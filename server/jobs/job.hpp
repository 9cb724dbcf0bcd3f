// A job as others see it.
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
/// Nothing for a text that names none.
std::optional<JobState> job_state_named(std::string_view name);

/// A job at one moment.
struct JobView {
  std::string id;
  std::string owner;          ///< whose it is; may be empty
  std::uint64_t version = 0;  ///< grows with every change
  JobState state = JobState::kQueued;
  std::string stage;     ///< import, prepare, tetrahedralize, clip, encode; empty before the first
  int percent = 0;       ///< 0 to 100, never falls while the server runs, though the job begins again
  bool durable = false;  ///< it is on the disk: it would go on after a restart
  /// When it was asked for: no two jobs have the same.
  std::chrono::sys_time<std::chrono::microseconds> created{};
  std::optional<std::chrono::sys_time<std::chrono::microseconds>> finished_at{};
  std::optional<std::size_t> queue_position;  ///< how many go before it, while it is queued
  std::string result_key;                     ///< RequestKeys::result
  /// What it came to, while that is kept for it. A job that is done and was done before a restart has none:
  /// its result is in the disk tier.
  std::shared_ptr<const FractureAnswer> answer;
  std::optional<Error> error;

  bool finished() const { return state != JobState::kQueued && state != JobState::kRunning; }
};

}  // namespace fracture
