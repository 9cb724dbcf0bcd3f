// What others' memory crowded out begins again, and what an earlier process left on the disk goes on: a few
// at a time, so that a server that starts does not read all their meshes at once. A job that was being computed when that process ended is a suspect: it may
// have been the end of it. Suspects come last and one by one, so that whoever ends the server again is alone
// when it happens; the second time it has failed.
#include <algorithm>
#include <utility>

#include "server/jobs/jobs.hpp"

namespace fracture {
namespace {

/// Processes that may end while they compute a job.
constexpr std::uint64_t kMostEnds = 2;
/// No further mesh is read from the disk while those of resumed jobs hold more than this.
constexpr std::uint64_t kMostBytes = 64u << 20;

}  // namespace

void Jobs::restore() {
  const auto now = std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
  for (JobFolder::Found& found : folder_->restore()) {
    const auto job = std::make_shared<Job>();
    job->record = std::move(found.record);
    const JobRecord& record = job->record;
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
    last_created_ = std::max(last_created_, record.created);
    if (record.state == JobState::kDone && !dispatcher_.service().tiers().on_disk(record.result_key)) {
      folder_->remove(record.id);  // evicted meanwhile: nothing is left that could be fetched
      continue;
    }
    insert(job);
    if (view.finished()) {
      const auto ago = record.finished_at ? now - *record.finished_at : std::chrono::microseconds(0);
      job->finished = Clock::now() -
                      std::clamp<std::chrono::microseconds>(ago, std::chrono::microseconds(0), config_.ttl);
    } else if (found.begun >= kMostEnds) {
      fail_locked(job,
                  {ErrorCode::kJobLost, "The server ended " + std::to_string(found.begun) +
                                            " times while it computed this job, which is not tried again."});
    } else {
      job->waiting = true;
    }
  }
}

void Jobs::resume(TermsOf terms_of, const std::function<void(const JobView&)>& known) {
  std::vector<JobView> done;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    terms_of_ = std::move(terms_of);
    for (const Shared& job : jobs_)
      if (job->view.state == JobState::kDone) done.push_back(job->view);
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
  const bool crowded_out = error.code == ErrorCode::kOutOfMemory && needed != error.extra->end();
  if (job->suspended) return crowded_out || error.code == ErrorCode::kCancelled;
  if (!crowded_out || stopping_ || job->stop.stop_requested() || !(job->request || job->kept)) return false;
  // That much was not enough; half as much more is little, so that it needs few attempts.
  job->least_bytes = needed->get<std::uint64_t>() / 2 * 3;
  job->waiting = true;
  return true;
}

void Jobs::pump_later() {
  if (pump_queued_) return;  // one will look at all that has changed until it begins
  if (std::none_of(jobs_.begin(), jobs_.end(), [this](const Shared& job) { return can_be_submitted(*job); }))
    return;
  disk_.run([this] { pump(); });
  pump_queued_ = true;
}

void Jobs::pump() {
  {
    const std::lock_guard lock(mutex_);
    pump_queued_ = false;
  }
  for (;;) {
    Shared next, suspect;
    {
      const std::lock_guard lock(mutex_);
      std::size_t computing = 0;
      std::uint64_t bytes = 0;
      for (const Shared& job : jobs_) {
        if (job->computing) {
          ++computing;
          bytes += job->resumed_bytes;
          if (job->begun > 0) return;  // a suspect is alone
        }
        if (!can_be_submitted(*job)) continue;
        if (job->begun == 0 && !next) next = job;
        if (job->begun > 0 && !suspect) suspect = job;
      }
      if (!next && computing == 0) next = suspect;
      if (!next || bytes > kMostBytes ||
          computing >= 2 * static_cast<std::size_t>(dispatcher_.pool().threads()))
        return;
      next->waiting = false;
      next->computing = true;
    }
    if (resume_one(next)) continue;
    const std::lock_guard lock(mutex_);
    next->computing = false;
    next->waiting = !next->view.finished();
    return;  // sweep() tries again, and so does the next one that is finished
  }
}

std::optional<Error> Jobs::refuses(Terms& terms) {
  if (const auto& account = terms.payer.account; account && terms.needs_seat) {
    auto seat = account->begin_computation();
    if (!seat) return std::move(seat.error());
    terms.seat = std::make_shared<tenants::Account::Seat>(std::move(*seat));
  }
  MemoryBudget& working = dispatcher_.working();
  MemoryBudget::Reservation trial(working);
  if (!trial.grow_to(std::min(terms.least_bytes, working.capacity())))
    return overloaded("The memory that the job needs is not free.", std::chrono::seconds(10));
  return dispatcher_.refuses(ExpectedWork{}, terms);
}

bool Jobs::resume_one(const Shared& job) {
  JobRecord record;
  TermsOf terms_of;
  std::optional<FractureRequest> request;
  Terms before;  // of its last attempt in this process; without a deadline: there was none
  {
    const std::lock_guard lock(mutex_);
    record = job->record;
    terms_of = terms_of_;
    request = job->request;
    before = job->terms;
    before.least_bytes = job->least_bytes;
  }
  const auto lost = [&](Error error) {
    finish(job, tl::unexpected<Error>(std::move(error)));
    return true;
  };
  if (Clock::now() > before.deadline) return lost(to_error(Interrupted{ErrorCode::kDeadlineExceeded}));
  if (request) return !submit(job, std::move(*request), std::move(before));
  if (!terms_of) return false;
  Terms terms = terms_of(record.owner);
  terms.least_bytes = before.least_bytes;
  terms.priority = Priority::kBackground;
  terms.deadline = std::min(before.deadline, Clock::now() + record.patience);
  if (refuses(terms)) return false;
  std::optional<KeptMesh> mesh = folder_->read_mesh(record.digest);
  if (!mesh)
    return lost(
        {ErrorCode::kJobLost, "What was kept of the mesh of this job is damaged or gone. Send it again."});
  std::vector<RawParameter> given;
  for (const auto& [name, value] : record.parameters.items()) given.push_back({name, value, false});
  Expected<RequestParameters> parameters = dispatcher_.service().parameters().parse(given);
  if (!parameters) return lost(std::move(parameters.error()));  // of another version of the server

  request = FractureRequest{mesh->mesh, record.format, std::move(*parameters), std::move(mesh->files)};
  request->output = record.output;
  request->owner = mesh->owner;
  request->digest = record.digest;
  request->triangles = record.triangles;
  const std::string key = keys_of(*request).result;
  {
    const std::lock_guard lock(mutex_);
    job->view.result_key = job->record.result_key = key;  // another one where the algorithm has changed
    job->resumed_bytes = mesh->owner->size();
  }
  if (submit(job, std::move(*request), std::move(terms))) return false;
  const std::lock_guard lock(mutex_);
  ++figures_.resumed;
  return true;
}

}  // namespace fracture
