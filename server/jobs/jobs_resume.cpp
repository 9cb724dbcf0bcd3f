// Resumes jobs that were stopped for lack of memory, and jobs that an earlier process left on disk. Only a
// few run at a time, so that a starting server does not read all meshes at once. A job that was being
// computed when that process ended is a suspect, because it may have crashed the process. Suspects run last
// and one at a time: if the server crashes again, only the guilty one was running. After kMostEnds crashes, a
// job fails.
#include <algorithm>
#include <map>
#include <new>
#include <set>
#include <string_view>
#include <utility>

#include "common/base/words.hpp"
#include "common/parameters/parameter_object.hpp"
#include "server/jobs/jobs.hpp"

namespace fracture {
namespace {

/// A job fails after this many processes have ended while they computed it.
constexpr std::uint64_t kMostEnds = 2;
/// Client in DiskWork for calls of pump().
const std::string kNobody;
/// No further mesh is read from disk while the meshes of resumed jobs take more than this.
constexpr std::uint64_t kMostBytes = 64u << 20;
/// The first job of a holder may exceed the limits on the number and bytes of resumed jobs by this factor.
constexpr std::size_t kForFirst = 4;

/// Returns the terms for a job with this owner and client in its record (see Jobs::TermsOf).
Terms terms_for(const std::string& owner, const std::string& client, const Jobs::TermsOf& terms_of) {
  Terms terms = terms_of(owner);
  if (!terms.payer.account && !client.empty()) terms.payer.flow.name = client;
  return terms;
}

/// Returns the holder for these jobs until their terms are known.
const std::string& provisional_holder(const std::string& owner, const std::string& client) {
  return client.empty() ? owner : client;
}

/// Returns the holder for these jobs. If the terms are not available now, returns the provisional one; the
/// later attempt to resume a job reports why.
std::string holder_of(const std::string& owner, const std::string& client, const Jobs::TermsOf& terms_of) {
  try {
    return terms_for(owner, client, terms_of).payer.flow.name;
  } catch (const std::exception&) {
    return provisional_holder(owner, client);
  }
}

Terms without_seat(Terms terms) {
  terms.seat.reset();
  return terms;
}

}  // namespace

Expected<bool> Jobs::take_folder() {
  if (!folder_ || folder_ready_) return true;
  ResultTiers& tiers = dispatcher_.service().tiers();
  // A finished job can only be shown with its result, which is in the disk tier.
  if (tiers.waits_for_folder()) return false;
  const Expected<bool> taken = folder_->take();
  if (!taken || !*taken) return taken;
  restore();
  tiers.keep_all_on_disk(false);
  folder_ready_ = true;
  go_on();
  return true;
}

void Jobs::restore() {
  const auto now = std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
  std::vector<JobFolder::Found> all = folder_->restore();
  ResultTiers& tiers = dispatcher_.service().tiers();
  const std::lock_guard lock(mutex_);
  for (JobFolder::Found& found : all) {
    if (index_.contains(found.record.id)) continue;  // loaded by an earlier attempt that ran out of memory
    const auto job = std::make_shared<Job>();
    job->record = std::move(found.record);
    const JobRecord& record = job->record;
    if (record.state == JobState::kDone && !tiers.on_disk(record.result_key)) {
      job->record.state = JobState::kFailed;
      job->record.error = Error{
          ErrorCode::kJobLost,
          "The job's result was removed from the disk cache, because the cache was full (--disk-cache) or "
          "the file was damaged. Send the mesh and the request again."};
    }
    JobView& view = job->view;
    view.id = record.id;
    view.owner = record.owner;
    view.version = 1;
    view.state = record.state;
    view.percent = record.state == JobState::kDone ? 100 : 0;
    view.created = record.created;
    view.finished_at = record.finished_at;
    view.result_key = record.result_key;
    view.error = record.error;
    view.durable = job->kept = true;
    job->begun = found.begun;
    job->client = job->holder = provisional_holder(record.owner, record.client);
    // Ignore a time in the future (a wrong clock or a forged record): it must not affect the times of new
    // jobs.
    if (record.created <= now) last_created_ = std::max(last_created_, record.created);
    insert(job);
    if (view.finished()) {
      const auto ago = record.finished_at ? now - *record.finished_at : std::chrono::microseconds(0);
      job->finished = Clock::now() -
                      std::clamp<std::chrono::microseconds>(ago, std::chrono::microseconds(0), config_.ttl);
    } else if (found.begun >= kMostEnds) {
      fail_locked(job, {ErrorCode::kJobLost,
                        "The server ended " + std::to_string(found.begun) +
                            " times while it was computing this job, so the job is not tried again."});
    } else {
      job->waiting = true;
    }
    if (record.state == JobState::kDone) {
      tiers.pin(record.result_key);
      if (!charge_pin(*job, tiers.bytes_on_disk(record.result_key))) tiers.unpin(record.result_key);
    }
  }
}

void Jobs::resume(TermsOf terms_of, std::function<void(const JobView&)> known) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    terms_of_ = std::move(terms_of);
    known_ = std::move(known);
  }
  go_on();
}

void Jobs::go_on() {
  std::vector<JobView> done;
  std::function<void(const JobView&)> known;
  TermsOf terms_of;
  std::map<std::pair<std::string, std::string>, std::string> holders;  // by owner and client
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ || !terms_of_) return;
    known = known_;
    terms_of = terms_of_;
    for (const Shared& job : jobs_)
      if (!job->terms) holders.try_emplace({job->view.owner, job->record.client});
  }
  for (auto& [of, holder] : holders) holder = holder_of(of.first, of.second, terms_of);
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ || !terms_of_) return;
    for (const Shared& job : jobs_) {
      if (const auto holder = holders.find({job->view.owner, job->record.client});
          !job->terms && holder != holders.end())
        hand_over(*job, holder->second);
      if (job->view.state == JobState::kDone && !job->view.answer) done.push_back(job->view);
    }
    pump_later();
  }
  for (const JobView& view : done) known(view);
}

void Jobs::stop_resuming() {
  const std::lock_guard lock(mutex_);
  terms_of_ = nullptr;
}

bool Jobs::begins_again(const Shared& job, const Error& error) {
  const auto needed = error.extra->find("bytes");
  const bool over_share = error.code == ErrorCode::kOverShare;
  const bool lacked_memory =
      (error.code == ErrorCode::kOutOfMemory || over_share) && needed != error.extra->end();
  const bool crowded_out = lacked_memory || over_share || error.code == ErrorCode::kOverloaded;
  if (job->suspended) return crowded_out || error.code == ErrorCode::kCancelled;
  if (!crowded_out || stopping_ || job->stop.stop_requested() || !(job->request || job->kept)) return false;
  if (lacked_memory) {
    // The memory was not enough. Ask for half as much more, so that few attempts are needed, up to three
    // quarters of all memory, which leaves some for others. Beyond that, each attempt halves the distance to
    // all memory.
    const auto bytes = needed->get<std::uint64_t>();
    const std::uint64_t all = dispatcher_.working().capacity(), most = all / 4 * 3;
    const std::uint64_t next =
        bytes < most ? std::min(bytes / 2 * 3, most) : bytes + (all - std::min(bytes, all)) / 2;
    job->least_bytes = std::max(job->least_bytes, next);
  }
  job->waiting = true;
  return true;
}

void Jobs::pump_later() {
  if (pump_queued_) return;  // the queued call handles all changes until it begins
  if (std::none_of(jobs_.begin(), jobs_.end(), [this](const Shared& job) { return can_be_submitted(*job); }))
    return;
  disk_.run(kNobody, [this] { pump(); });
  pump_queued_ = true;
}

Jobs::Calls Jobs::end_waits() {
  Calls calls;
  for (const Shared& job : jobs_) {
    if (!job->waiting || job->suspended) continue;
    const bool cancelled = job->stop.stop_requested();  // cancelled while being submitted, then refused
    if (!cancelled && !(job->deadline && Clock::now() > *job->deadline)) continue;
    fail_locked(job, to_error(Interrupted{cancelled ? ErrorCode::kCancelled : ErrorCode::kDeadlineExceeded}));
    for (auto& call : change(job)) calls.push_back(std::move(call));
  }
  return calls;
}

Jobs::Shared Jobs::next_to_submit(const std::set<std::string>& over_share) {
  std::size_t computing = 0;
  std::uint64_t bytes = 0;
  bool suspect_computes = false;
  std::set<std::string_view> compute;  // holders of jobs being computed
  for (const Shared& job : jobs_) {
    if (!job->computing) continue;
    ++computing;
    bytes += job->resumed_bytes;
    suspect_computes = suspect_computes || job->begun > 0;
    compute.insert(job->holder);
  }
  const std::size_t most = 2 * static_cast<std::size_t>(dispatcher_.pool().threads());
  const auto is_room = [&](std::size_t times) {
    return bytes <= times * kMostBytes && computing < times * most;
  };
  const bool room = is_room(1), room_for_first = is_room(kForFirst);
  if (!room && !room_for_first) return nullptr;
  Shared suspect;
  for (const Shared& job : jobs_) {
    if (!can_be_submitted(*job) || job->refused_in == pass_ || over_share.contains(job->holder)) continue;
    if (!room && compute.contains(job->holder)) continue;
    if (job->begun > 0) {
      if (!suspect) suspect = job;
    } else if (job->terms || !suspect_computes) {
      return job;  // a job begun in this process may run with a suspect
    }
  }
  return computing == 0 ? suspect : nullptr;
}

void Jobs::pump() {
  std::set<std::string> over_share;  // holders whose other jobs are skipped in this pass
  Calls calls;
  {
    const std::lock_guard lock(mutex_);
    pump_queued_ = false;
    ++pass_;
    calls = end_waits();
  }
  while (!dispatcher_.pool().full(Priority::kBackground)) {
    for (const auto& call : std::exchange(calls, {})) call();
    Shared next;
    {
      const std::lock_guard lock(mutex_);
      next = next_to_submit(over_share);
      if (!next) return;
      next->waiting = false;
      next->computing = true;
    }
    std::optional<Error> refused;
    try {
      refused = resume_one(next);
    } catch (const std::bad_alloc&) {
      finish(next, fail(ErrorCode::kOutOfMemory, "There was not enough memory to continue this job."));
    } catch (const std::exception& e) {
      finish(next, fail(ErrorCode::kInternal, e.what()));
    }
    if (!refused) continue;
    const bool no_place = dispatcher_.pool().full(Priority::kBackground, {next->holder, 1});
    const std::lock_guard lock(mutex_);
    next->computing = false;
    next->waiting = !next->view.finished();
    calls = end_waits();
    // Another job may need less memory or have another holder. This one is retried by sweep() and after the
    // next job that finishes.
    next->refused_in = pass_;
    if (no_place || refused->code == ErrorCode::kOverShare) over_share.insert(next->holder);
  }
  for (const auto& call : calls) call();
}

std::optional<Error> Jobs::refuses(Terms& terms) {
  if (const auto& account = terms.payer.account; account && terms.needs_seat) {
    auto seat = account->begin_computation();
    if (!seat) return std::move(seat.error());
    terms.seat = std::make_shared<tenants::Account::Seat>(std::move(*seat));
  }
  const MemoryBudget& working = dispatcher_.working();
  if (working.judge(nullptr, std::min(terms.least_bytes, working.capacity())) != MemoryBudget::Verdict::kFits)
    return overloaded("The memory that the job needs is in use.", std::chrono::seconds(10));
  return dispatcher_.refuses(ExpectedWork{}, terms);
}

std::optional<Error> Jobs::resume_one(const Shared& job) {
  JobRecord record;
  TermsOf terms_of;
  std::optional<FractureRequest> request;
  std::optional<Terms> before;
  std::uint64_t least_bytes = 0;
  {
    const std::lock_guard lock(mutex_);
    record = job->record;
    terms_of = terms_of_;
    request = job->request;
    before = job->terms;
    least_bytes = job->least_bytes;
  }
  const auto lost = [&](Error error) {
    finish(job, tl::unexpected<Error>(std::move(error)));
    return std::nullopt;
  };
  if (request) {
    before->least_bytes = least_bytes;
    return submit(job, std::move(*request), std::move(*before));
  }
  if (!terms_of) return overloaded("The server is stopping.", std::chrono::seconds(5));
  Terms terms;
  if (before) {
    terms = std::move(*before);
  } else {
    terms = terms_for(record.owner, record.client, terms_of);
    terms.priority = Priority::kBackground;
    const std::lock_guard lock(mutex_);
    if (!job->deadline) job->deadline = Clock::now() + record.patience;
    terms.deadline = *job->deadline;
  }
  if (const std::uint64_t most = dispatcher_.working().capacity(); record.mesh_bytes > most)
    return lost({ErrorCode::kJobLost, "The mesh of this job has " + data_size(record.mesh_bytes) +
                                          "; the limit for a computation is " + data_size(most) +
                                          " (--max-working). Send a smaller mesh, or raise the limit."});
  terms.least_bytes = std::max(least_bytes, record.mesh_bytes);  // the mesh is read before admission
  if (auto refused = refuses(terms)) return refused;
  const std::optional<JobRecord> whole = folder_->read(record.id);
  if (!whole)
    return lost(
        {ErrorCode::kJobLost, "The record of this job is damaged or missing. Send the request again."});
  std::optional<KeptMesh> mesh = folder_->read_mesh(record.digest);
  if (!mesh)
    return lost({ErrorCode::kJobLost,
                 "The stored mesh of this job is damaged or missing. Send the mesh and the request again."});
  Expected<RequestParameters> parameters =
      dispatcher_.service().parameters().parse(raw_parameters(whole->parameters));
  if (!parameters) return lost(std::move(parameters.error()));  // from another server version

  request = FractureRequest{mesh->mesh, record.format, std::move(*parameters), std::move(mesh->files)};
  request->output = record.output;
  request->owner = mesh->owner;
  request->digest = record.digest;
  request->triangles = record.triangles;
  request->keys = std::make_shared<const RequestKeys>(keys_of(*request));
  const std::string key = request->keys->result;
  {
    const std::lock_guard lock(mutex_);
    set_result_key(*job, key);  // differs if the algorithm has changed
    job->resumed_bytes = mesh->owner->size();
  }
  const Terms kept = without_seat(terms);
  const std::optional<Error> refused = submit(job, std::move(*request), std::move(terms));
  const std::lock_guard lock(mutex_);
  if (refused) {  // do not read the mesh again until enough memory is free
    if (const auto bytes = refused->extra->find("bytes"); bytes != refused->extra->end())
      job->least_bytes = std::max(job->least_bytes, bytes->get<std::uint64_t>());
    return refused;
  }
  figures_.resumed += !job->terms;
  job->terms = kept;
  return std::nullopt;
}

}  // namespace fracture
