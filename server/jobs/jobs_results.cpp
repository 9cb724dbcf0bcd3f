// Results of jobs: finds them, says who may fetch them, and fails done jobs whose results are lost.
#include <algorithm>
#include <ranges>
#include <utility>

#include "server/jobs/jobs.hpp"

namespace fracture {
namespace {

Error result_is_lost() {
  return {
      ErrorCode::kJobLost,
      "The job's result was removed, because results of jobs need more memory or disk than they may use "
      "(--job-results, --disk-cache), or because its file was damaged. Send the mesh and the request again."};
}

}  // namespace

bool Jobs::let_result_go(const Job& job) {
  return job.view.state == JobState::kDone && !job.view.answer && !job.writes_end;
}

std::shared_ptr<const FractureResult> Jobs::find_result(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto [begin, end] = by_result_.equal_range(key);
  for (const auto& [same, job] : std::ranges::subrange(begin, end))
    if (const auto answer = job->view.answer ? job->view.answer : job->being_written.lock())
      return answer->result;
  return nullptr;
}

bool Jobs::has_result(const std::string& owner, const std::string& key) {
  const std::lock_guard lock(mutex_);
  const Clock::time_point time = Clock::now();
  const auto [begin, end] = by_result_.equal_range(key);
  return std::any_of(begin, end, [&](const auto& entry) {
    const Job& job = *entry.second;
    return job.view.owner == owner && job.view.state == JobState::kDone && time - job.finished < config_.ttl;
  });
}

bool Jobs::needs_result(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto [begin, end] = by_result_.equal_range(key);
  return std::any_of(begin, end, [](const auto& entry) {
    const JobView& view = entry.second->view;
    return view.state == JobState::kDone || !view.finished();
  });
}

bool Jobs::check_result(const Shared& job) {
  std::string key;
  {
    const std::lock_guard lock(mutex_);
    if (!let_result_go(*job)) return false;
    key = job->view.result_key;
  }
  FractureService& service = dispatcher_.service();
  if (service.has_result(key) || service.tiers().expected_bytes(key)) return false;
  Calls calls;
  {
    const std::lock_guard lock(mutex_);
    if (!let_result_go(*job)) return false;
    const Counted recount(*this, *job);
    job->view.state =
        JobState::kFailed;  // the record stays done: the next process looks for the result again
    job->view.error = result_is_lost();
    calls = change(job);
  }
  for (const auto& call : calls) call();
  return true;
}

std::optional<Error> Jobs::lost_result(const std::string& key,
                                       const std::function<bool(const std::string& owner)>& sees,
                                       bool nowhere) {
  std::vector<Shared> promised;
  {
    const std::lock_guard lock(mutex_);
    const auto [begin, end] = by_result_.equal_range(key);
    for (const auto& [same, job] : std::ranges::subrange(begin, end))
      if (sees(job->view.owner)) {
        promised.push_back(job);
        nowhere = nowhere && !job->writes_end;  // otherwise it may be there by now
      }
  }
  for (const Shared& job : promised) check_result(job);
  FractureService& service = dispatcher_.service();
  nowhere = nowhere && !service.has_result(key) && !service.tiers().on_disk(key);
  const std::lock_guard lock(mutex_);
  for (const Shared& job : promised) {
    const std::optional<Error>& error = job->view.error;
    if (error && error->code == ErrorCode::kJobLost) return error;
    if (nowhere && let_result_go(*job)) return result_is_lost();
  }
  return std::nullopt;
}

}  // namespace fracture
