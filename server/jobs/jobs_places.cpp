// Holders of jobs: counts their jobs and decides which jobs are removed for new ones.
#include <algorithm>
#include <new>
#include <utility>

#include "server/jobs/jobs.hpp"
#include "server/service/fair_share.hpp"

namespace fracture {
namespace {

/// Limits on the unfinished jobs of clients that have more than one. Together, these clients may use half of
/// all jobs, and a single client three quarters of that half. The other half is reserved for the first job of
/// each client.
FairShare unfinished_share(std::size_t max_jobs) {
  const std::size_t half = max_jobs - max_jobs / 2;
  return {half, half - half / 4};
}

std::uint64_t bytes_of(const JobView& view) { return view.answer ? view.answer->result->file.size() : 0; }

}  // namespace

void Jobs::count(const Job& job, bool held) {
  Held& sum = held_.at(job.holder);
  const auto add = [held](auto& number, auto more) { held ? number += more : number -= more; };
  const std::uint64_t bytes = bytes_of(job.view);
  add(sum.jobs, std::size_t{1});
  add(sum.unfinished, std::size_t{!job.view.finished()});
  add(sum.result_bytes, bytes);
  add(figures_.result_bytes, bytes);
  add(sum.pinned_bytes, job.pinned_bytes);
  add(figures_.pinned_bytes, job.pinned_bytes);
}

void Jobs::hand_over(Job& job, const std::string& holder) {
  count(job, false);
  if (const auto before = held_.find(job.holder); before->second.jobs == 0) held_.erase(before);
  job.holder = holder;
  held_.try_emplace(holder);
  count(job, true);
}

void Jobs::insert(const Shared& job) {
  held_.try_emplace(job->holder);
  auto at = jobs_.end();
  while (at != jobs_.begin() && (*std::prev(at))->view.created > job->view.created) --at;
  at = jobs_.insert(at, job);
  try {
    job->by_result = by_result_.emplace(job->view.result_key, job);
  } catch (const std::bad_alloc&) {
    jobs_.erase(at);
    throw;
  }
  try {
    index_.emplace(job->view.id, at);
  } catch (const std::bad_alloc&) {
    by_result_.erase(job->by_result);
    jobs_.erase(at);
    throw;
  }
  count(*job, true);
}

void Jobs::forget(std::list<Shared>::iterator at) {
  const Shared job = *at;
  unpin(*job);
  if (std::exchange(job->kept, false))
    disk_.run(job->client, [this, id = job->view.id] { folder_->remove(id); });
  count(*job, false);
  if (const auto held = held_.find(job->holder); held->second.jobs == 0) held_.erase(held);
  by_result_.erase(job->by_result);
  index_.erase(job->view.id);
  jobs_.erase(at);
}

void Jobs::set_result_key(Job& job, const std::string& key) {
  std::string in_view = key, in_record = key, in_index = key;  // nothing is half done if memory is short
  job.view.result_key.swap(in_view);
  job.record.result_key.swap(in_record);
  if (!index_.contains(job.view.id)) return;
  ByResult::node_type node = by_result_.extract(job.by_result);
  node.key().swap(in_index);
  job.by_result = by_result_.insert(std::move(node));
}

std::list<Jobs::Shared>::iterator Jobs::oldest_of(const std::string& holder, bool (*wanted)(const Job&)) {
  return std::find_if(jobs_.begin(), jobs_.end(),
                      [&](const Shared& job) { return job->holder == holder && wanted(*job); });
}

Jobs::Job& Jobs::oldest_of_most(std::uint64_t Held::*sum, bool (*wanted)(const Job&)) {
  const auto most = std::max_element(held_.begin(), held_.end(), [sum](const auto& a, const auto& b) {
    return a.second.*sum < b.second.*sum;
  });
  return **oldest_of(most->first, wanted);
}

bool Jobs::charge_pin(Job& job, std::uint64_t bytes) {
  const std::uint64_t most = dispatcher_.service().tiers().most_pinned();
  if (!job.kept || bytes == 0 || bytes > most) return false;
  {
    const Counted recount(*this, job);
    job.pinned_bytes = bytes;
  }
  while (figures_.pinned_bytes > most)
    unpin(oldest_of_most(&Held::pinned_bytes, [](const Job& known) { return known.pinned_bytes > 0; }));
  return true;
}

void Jobs::unpin(Job& job) {
  if (job.pinned_bytes == 0) return;
  // As disk work, so that this thread does not wait for the disk tier. Not as work of the job's client: behind that
  // client's waiting writes, the pin would take room from others for too long.
  disk_.run("(unpin)", [this, key = job.view.result_key] { dispatcher_.service().tiers().unpin(key); });
  const Counted recount(*this, job);
  job.pinned_bytes = 0;
}

/// Forgets expired jobs. While the results exceed their limit, the holder with the most bytes loses its
/// oldest result. That job stays done while its result is in a tier or in the cache (check_result).
void Jobs::make_room() {
  const Clock::time_point time = Clock::now();
  for (auto at = jobs_.begin(); at != jobs_.end();) {
    const auto next = std::next(at);
    if ((*at)->view.finished() && time - (*at)->finished >= config_.ttl) {
      forget(at);
      ++figures_.expired;
    }
    at = next;
  }
  while (figures_.result_bytes > config_.max_result_bytes) {
    Job& job = oldest_of_most(&Held::result_bytes, [](const Job& known) { return bytes_of(known.view) > 0; });
    const Counted recount(*this, job);
    job.view.answer.reset();
    ++figures_.results_evicted;
  }
}

/// Removes the oldest finished job of the holder with the most jobs, but never one of a holder that has no
/// more jobs than the new holder will have. Unfinished jobs are not removed, so their number is limited for
/// each client.
std::optional<Error> Jobs::make_place_for(const std::string& holder) {
  const auto mine = held_.find(holder);
  const Held own = mine == held_.end() ? Held{} : mine->second;
  std::size_t unfinished = 0, others = 0;
  for (const auto& [name, held] : held_) {
    unfinished += held.unfinished;
    others += held.unfinished > 0 && name != holder;
  }
  const bool first = own.unfinished == 0;
  if (first ? unfinished >= config_.max_jobs
            : !unfinished_share(config_.max_jobs).allows(own.unfinished + 1, unfinished + 1, others, false)) {
    const std::string all = std::to_string(unfinished) + " unfinished jobs";
    if (first)
      return overloaded("There are " + all + ", which is the limit (--max-jobs).", std::chrono::seconds(10));
    return Error{.code = ErrorCode::kOverShare,
                 .detail = "There are " + all + ". This client has " + std::to_string(own.unfinished) +
                           " of them, which is its share. Send the request again when one of this "
                           "client's jobs is finished.",
                 .retry_after = std::chrono::seconds(10)};
  }
  if (jobs_.size() < config_.max_jobs) return std::nullopt;
  const std::pair<const std::string, Held>* most = nullptr;
  for (const auto& entry : held_) {
    const bool has_finished = entry.second.jobs > entry.second.unfinished;
    const bool may = entry.first == holder || entry.second.jobs > own.jobs;
    if (has_finished && may && (!most || entry.second.jobs > most->second.jobs)) most = &entry;
  }
  if (!most)
    return Error{
        .code = own.jobs > 0 ? ErrorCode::kOverShare : ErrorCode::kOverloaded,
        .detail = "There are " + std::to_string(jobs_.size()) +
                  " jobs, which is the limit (--max-jobs), and none of them can be deleted to make room.",
        .retry_after = std::chrono::seconds(10)};
  forget(oldest_of(most->first, [](const Job& known) { return known.view.finished(); }));
  ++figures_.evicted;
  return std::nullopt;
}

}  // namespace fracture
