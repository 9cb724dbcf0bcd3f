// The life of a job in this process. Related files: jobs_disk.cpp stores jobs, jobs_resume.cpp continues
// those from an earlier process, jobs_watch.cpp shows them to clients, and jobs_results.cpp finds their results.
#include "server/jobs/jobs.hpp"

#include <algorithm>
#include <new>
#include <random>
#include <utility>

#include "common/base/words.hpp"
#include "server/jobs/job_percent.hpp"

namespace fracture {
namespace {

std::string random_digits() {
  constexpr char kDigits[] = "0123456789abcdef";
  std::random_device device;
  std::string digits;
  while (digits.size() < 16) {
    std::uint32_t word = device();
    for (int i = 0; i < 8; ++i, word >>= 4) digits += kDigits[word & 15];
  }
  return digits;
}

std::uint64_t bytes_of(const FractureRequest& request) {
  std::uint64_t bytes = request.mesh.size();
  for (const ImportFile& file : request.files) bytes += file.name.size() + file.bytes.size();
  return bytes;
}

std::chrono::sys_time<std::chrono::microseconds> now() {
  return std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
}

}  // namespace

Jobs::Jobs(Dispatcher& dispatcher, const JobsConfig& config) : dispatcher_(dispatcher), config_(config) {
  if (config_.folder.empty()) return;
  dispatcher_.service().tiers().keep_all_on_disk(true);  // until take_folder() has pinned the results of jobs
  folder_ = std::make_unique<JobFolder>(
      JobFolderConfig{config_.folder, config_.max_disk_bytes, config_.keys, config_.max_jobs});
  if (const Expected<bool> taken = take_folder(); !taken) {
    folder_unusable_ = taken.error();
    folder_.reset();
    dispatcher_.service().tiers().keep_all_on_disk(false);
  }
}

Jobs::~Jobs() { stop(); }

std::optional<Error> Jobs::start(FractureRequest request, Terms terms, const Owner& owner,
                                 std::function<void(const JobView&)> accepted) {
  const auto keys = std::make_shared<const RequestKeys>(keys_of(request));
  request.keys = keys;
  request.digest = keys->digest;
  const auto job = std::make_shared<Job>();
  job->view.id = job->record.id = keys->digest.substr(0, 16) + "-" + random_digits();
  job->view.owner = job->record.owner = owner.name;
  job->view.result_key = job->record.result_key = keys->result;
  job->client = job->holder = job->record.client = terms.payer.flow.name;
  {
    const std::lock_guard lock(mutex_);
    make_room();
    if (stopping_) return overloaded("The server is stopping.", std::chrono::seconds(5));
    if (auto refused = make_place_for(job->holder)) return refused;
    job->view.created = job->record.created = last_created_ =
        std::max(now(), last_created_ + std::chrono::microseconds(1));
    insert(job);
    ++figures_.started;
  }
  const auto not_started = [&] {
    const std::lock_guard lock(mutex_);
    if (const auto at = index_.find(job->view.id); at != index_.end()) forget(at->second);
    --figures_.started;
  };
  try {
    std::optional<Error> refused =
        begin(job, std::move(request), std::move(terms), owner, std::move(accepted));
    if (refused) not_started();
    return refused;
  } catch (const std::exception&) {  // out of memory: the client was not told of the job
    job->stop.request_stop();
    not_started();
    throw;
  }
}

std::optional<Error> Jobs::begin(const Shared& job, FractureRequest request, Terms terms, const Owner& owner,
                                 std::function<void(const JobView&)> accepted) {
  std::shared_ptr<const FractureRequest> written;  // keeps the bytes alive until they are on disk
  if (folder_ready_) {
    JobRecord& kept = job->record;
    kept.patience = std::max(std::chrono::milliseconds(1),
                             std::chrono::ceil<std::chrono::milliseconds>(terms.deadline - Clock::now()));
    kept.digest = request.digest;
    kept.mesh_bytes = bytes_of(request);
    kept.format = request.format;
    kept.output = request.output;
    kept.triangles = request.triangles;
    JobRecord whole = kept;
    whole.parameters = canonical_parameters(request.parameters);
    if (auto overload = room_for(job, whole, owner.share)) return overload;
    if (job->kept) written = std::make_shared<const FractureRequest>(request);
  }
  job->terms = terms;
  job->terms->seat.reset();
  job->deadline = terms.deadline;
  job->request = request;  // until it is on disk
  if (auto overload = submit(job, std::move(request), std::move(terms))) return overload;
  if (!written) {
    accepted(look_at(job));
    return std::nullopt;
  }
  disk_.run(job->client, [this, job, written = std::move(written), accepted = std::move(accepted)] {
    try {
      persist(job, *written);
    } catch (const std::exception&) {  // out of memory for the record: compute the job anyway
      not_durable(job);
    }
    accepted(look_at(job));
  });
  return std::nullopt;
}

std::optional<Error> Jobs::room_for(const Shared& job, const JobRecord& record, std::uint64_t share) {
  switch (folder_->reserve(record, share)) {
    case JobFolder::Room::kThere: {
      const std::lock_guard lock(mutex_);
      job->kept = true;
      break;
    }
    case JobFolder::Room::kFull:
      return overloaded("The jobs on disk use all of the " + std::to_string(config_.max_disk_bytes) +
                            " bytes of --job-store.",
                        std::chrono::seconds(10));
    case JobFolder::Room::kOverShare:
      return Error{.code = ErrorCode::kOverShare,
                   .detail = "The unfinished jobs of '" + job->view.owner + "' use " +
                             std::to_string(folder_->bytes_of(job->view.owner)) +
                             " bytes on disk. With this job, they would exceed the share of " +
                             std::to_string(share) +
                             " bytes. Send the request again when one of those "
                             "jobs is finished.",
                   .retry_after = std::chrono::seconds(10)};
    case JobFolder::Room::kOverPart:
      return Error{
          .code = ErrorCode::kOverShare,
          .detail = "This client's jobs use its whole share of the " +
                    std::to_string(config_.max_disk_bytes) +
                    " bytes for jobs on disk (--job-store). Send the request again when one of those "
                    "jobs is finished.",
          .retry_after = std::chrono::seconds(10)};
    case JobFolder::Room::kTooLarge:
    case JobFolder::Room::kUnfit:
      break;  // compute the job anyway; the answer says that it is not durable
  }
  return std::nullopt;
}

std::optional<Error> Jobs::submit(const Shared& job, FractureRequest request, Terms terms) {
  job->clip_begins = clip_begins(request.parameters.fracture.lloyd);
  terms.gone = job->stop.get_token();
  terms.progress = [this, weak = std::weak_ptr(job)](Stage stage, double fraction) {
    if (const Shared alive = weak.lock()) progress(alive, stage, fraction);
  };
  return dispatcher_.fracture(std::move(request), terms, [this, job](Expected<FractureAnswer> answer) {
    finish(job, std::move(answer));
  });
}

void Jobs::progress(const Shared& job, Stage stage, double fraction) {
  Calls calls;
  bool begins = false;
  {
    const std::lock_guard lock(mutex_);
    JobView& view = job->view;
    // The computation may continue for other waiters after this job has ended.
    if (view.finished() || job->suspended) return;
    const int percent = std::max(view.percent, percent_of(stage, fraction, job->clip_begins));
    const bool new_stage = view.stage != name_of(stage);
    begins = view.state != JobState::kRunning;
    if (!begins && percent == view.percent && !new_stage) return;
    begins = begins && job->kept;
    view.state = JobState::kRunning;
    view.percent = percent;
    if (new_stage) view.stage = name_of(stage);
    calls = change(job);
  }
  // Done here and not by the disk threads, so that the mark exists before any computation that could crash
  // the process.
  if (begins) mark_begun(job);
  for (const auto& call : calls) call();
}

void Jobs::mark_begun(const Shared& job) {
  if (config_.before_mark) config_.before_mark();
  folder_->begun(job->view.id);
  const std::lock_guard lock(mutex_);
  job->marked = job->view.state == JobState::kRunning;
  // If the job was stopped or ended in between, that code has found no mark to remove.
  if (!job->marked) disk_.run(job->client, [this, id = job->view.id] { folder_->not_begun(id); });
}

void Jobs::finish(const Shared& job, Expected<FractureAnswer> answer) {
  Calls calls;
  std::shared_ptr<const FractureAnswer> made;
  if (answer) try {
      made = std::make_shared<const FractureAnswer>(std::move(*answer));
    } catch (const std::bad_alloc&) {
      answer = fail(ErrorCode::kOutOfMemory, "There was not enough memory to keep the answer of this job.");
    }
  {
    const std::lock_guard lock(mutex_);
    JobView& view = job->view;
    job->computing = false;
    if (view.finished()) return;  // its computation ended although pump() failed to resume it
    if (!answer && begins_again(job, answer.error())) {
      view.state = JobState::kQueued;
      view.stage.clear();
      if (std::exchange(job->marked, false))  // marks of crashed processes remain
        disk_.run(job->client, [this, id = view.id] { folder_->not_begun(id); });
    } else if (!answer) {
      fail_locked(job, std::move(answer.error()));
    } else {
      const Counted recount(*this, *job);
      view.state = JobState::kDone;
      view.percent = 100;
      view.answer = std::move(made);
      ended(job);
    }
    calls = change(job);
    make_room();
    pump_later();
  }
  for (const auto& call : calls) call();
}

void Jobs::ended(const Shared& job) {
  job->request.reset();
  job->finished = Clock::now();
  job->view.finished_at = now();
  if (!job->kept) return;
  JobRecord& record = job->record;
  record.state = job->view.state;
  record.finished_at = job->view.finished_at;
  record.error = job->view.error;
  disk_.run(job->client, [this, job, answer = job->view.answer] { persist_end(job, answer); });
  job->writes_end = true;  // the disk work waits for the lock
  job->being_written = job->view.answer;
}

// -- ending jobs

bool Jobs::cancel(const std::string& id) {
  Shared job;
  Calls calls;
  {
    const std::lock_guard lock(mutex_);
    job = get(id);
    if (!job) return false;
    if (job->view.finished()) {
      forget(index_.at(id));
      return true;
    }
    if (job->waiting) {
      fail_locked(job, {ErrorCode::kCancelled, "The work was cancelled before it was done."});
      calls = change(job);
    }
  }
  for (const auto& call : calls) call();
  job->stop.request_stop();  // ends the job, unless it is finishing right now
  return true;
}

void Jobs::fail_locked(const Shared& job, Error error) {
  if (error.code == ErrorCode::kDeadlineExceeded)
    error.detail =
        "The job was stopped because its deadline passed. The deadline is the request's Request-Timeout, but at most the "
        "server's --job-deadline of " +
        short_number(static_cast<double>(config_.deadline.count()) / 1000) +
        " s. Ask for fewer sites, send a smaller mesh, or allow more time.";
  const Counted recount(*this, *job);
  job->waiting = false;
  job->view.state = error.code == ErrorCode::kCancelled ? JobState::kCancelled : JobState::kFailed;
  job->view.error = std::move(error);
  ended(job);
}

void Jobs::stop() {
  std::vector<Shared> unfinished;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    stopping_ = true;
    terms_of_ = nullptr;
    for (const Shared& job : jobs_) {
      if (job->waiting && !job->kept)
        fail_locked(
            job, {ErrorCode::kCancelled, "The server was stopped before it had the resources for this job."});
      if (job->view.finished()) continue;
      job->suspended = job->kept;
      unfinished.push_back(job);
    }
  }
  for (const Shared& job : unfinished) job->stop.request_stop();
}

void Jobs::sweep() {
  const std::lock_guard lock(mutex_);
  make_room();
  pump_later();
}

void Jobs::flush() {
  disk_.flush();  // also restarts jobs that wait for memory, even without a folder
}

JobFigures Jobs::figures() const {
  const std::lock_guard lock(mutex_);
  JobFigures figures = figures_;
  figures.jobs = jobs_.size();
  for (const Shared& job : jobs_) {
    figures.unfinished += !job->view.finished();
    figures.waiting += job->waiting && job->kept;
    figures.durable += job->kept && !job->view.finished();
  }
  return figures;
}

std::optional<JobFolderFigures> Jobs::disk_figures() const {
  return folder_ready_ ? std::optional(folder_->figures()) : std::nullopt;
}

std::uint64_t Jobs::disk_bytes_of(const std::string& owner) const {
  return folder_ready_ ? folder_->bytes_of(owner) : 0;
}

}  // namespace fracture
