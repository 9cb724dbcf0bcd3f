#include "server/jobs/job.hpp"

#include <utility>

namespace fracture {
namespace {

constexpr std::pair<JobState, const char*> kNames[] = {{JobState::kQueued, "queued"},
                                                       {JobState::kRunning, "running"},
                                                       {JobState::kDone, "done"},
                                                       {JobState::kFailed, "failed"},
                                                       {JobState::kCancelled, "cancelled"}};

}  // namespace

const char* name_of(JobState state) {
  for (const auto& [known, name] : kNames)
    if (known == state) return name;
  return "failed";
}

std::optional<JobState> job_state_named(std::string_view name) {
  for (const auto& [state, known] : kNames)
    if (name == known) return state;
  return std::nullopt;
}

}  // namespace fracture
