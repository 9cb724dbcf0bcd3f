#include "server/service/jobs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string_view>
#include <utility>

namespace fracture {
namespace {

/// Where each stage begins, in percent of the whole: roughly its share of the time for a mesh of 10k
/// triangles and 100 sites.
struct StageShare {
  std::string_view name;
  int begin, end;
};
constexpr std::array<StageShare, 5> kShares{{{"import", 1, 15},
                                             {"prepare", 15, 35},
                                             {"tetrahedralize", 35, 45},
                                             {"clip", 45, 90},
                                             {"encode", 90, 99}}};

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

std::uint64_t bytes_of(const JobView& view) { return view.result ? view.result->file.size() : 0; }

}  // namespace

const char* name_of(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return "queued";
    case JobState::kRunning:
      return "running";
    case JobState::kDone:
      return "done";
    case JobState::kFailed:
      return "failed";
    case JobState::kCancelled:
      return "cancelled";
  }
  return "failed";
}

tl::expected<JobView, Overload> Jobs::start(FractureRequest request, Terms terms, const std::string& owner) {
  const RequestKeys keys = keys_of(request);
  request.digest = keys.digest;
  const auto job = std::make_shared<Job>();
  job->view.id = keys.digest.substr(0, 16) + "-" + random_digits();
  job->view.owner = owner;
  job->result_key = keys.result;
  {
    const std::lock_guard lock(mutex_);
    make_room();
    if (jobs_.size() >= config_.max_jobs)
      return tl::unexpected<Overload>(
          Overload{"There are " + std::to_string(jobs_.size()) + " unfinished jobs, as many as there may be.",
                   std::chrono::seconds(10)});
    jobs_.push_back(job);
    index_.emplace(job->view.id, std::prev(jobs_.end()));
    ++figures_.started;
  }
  terms.gone = job->stop.get_token();
  terms.progress = [this, weak = std::weak_ptr(job)](const char* stage, double fraction) {
    if (const Shared alive = weak.lock()) progress(alive, stage, fraction);
  };
  auto overload =
      dispatcher_.fracture(std::move(request), terms,
                           [this, job](Expected<FractureAnswer> answer) { finish(job, std::move(answer)); });
  if (overload) {
    const std::lock_guard lock(mutex_);
    if (const auto at = index_.find(job->view.id); at != index_.end()) forget(at->second);
    --figures_.started;
    return tl::unexpected<Overload>(std::move(*overload));
  }
  return look_at(*job);
}

void Jobs::progress(const Shared& job, const char* stage, double fraction) {
  const auto share =
      std::find_if(kShares.begin(), kShares.end(), [&](const StageShare& s) { return s.name == stage; });
  std::vector<std::function<void()>> calls;
  {
    const std::lock_guard lock(mutex_);
    JobView& view = job->view;
    if (view.finished()) return;
    int percent = view.percent;
    if (share != kShares.end()) {
      percent = std::max(percent, share->begin + static_cast<int>((share->end - share->begin) *
                                                                  std::clamp(fraction, 0.0, 1.0)));
    } else if (std::string_view(stage) == "delaunay") {  // reported in steps, within its stage
      const StageShare& within = kShares[2];
      percent = std::max(percent, within.begin + static_cast<int>((within.end - within.begin) *
                                                                  std::clamp(fraction, 0.0, 1.0)));
    }
    const bool new_stage = share != kShares.end() && view.stage != stage;
    if (view.state == JobState::kRunning && percent == view.percent && !new_stage) return;
    view.state = JobState::kRunning;
    view.percent = percent;
    if (new_stage) view.stage = stage;
    calls = change(job);
  }
  for (const auto& call : calls) call();
}

void Jobs::finish(const Shared& job, Expected<FractureAnswer> answer) {
  std::vector<std::function<void()>> calls;
  {
    const std::lock_guard lock(mutex_);
    JobView& view = job->view;
    if (answer) {
      view.state = JobState::kDone;
      view.percent = 100;
      view.result = std::move(answer->result);
      if (index_.count(view.id) > 0) figures_.result_bytes += bytes_of(view);
    } else {
      view.state = answer.error().code == ErrorCode::kCancelled ? JobState::kCancelled : JobState::kFailed;
      view.error = std::move(answer.error());
    }
    job->finished = Clock::now();
    calls = change(job);
    make_room();
  }
  for (const auto& call : calls) call();
}

std::vector<std::function<void()>> Jobs::change(const Shared& job) {
  ++job->view.version;
  std::vector<std::function<void()>> calls;
  auto& watchers = job->watchers;
  for (auto& [seen, changed] : watchers)
    calls.push_back([call = std::move(changed), view = job->view] { call(view); });
  watchers.clear();
  return calls;
}

Jobs::Shared Jobs::get(const std::string& id) {
  const auto at = index_.find(id);
  return at == index_.end() ? nullptr : *at->second;
}

std::optional<JobView> Jobs::find(const std::string& id) {
  Shared job;
  {
    const std::lock_guard lock(mutex_);
    make_room();
    job = get(id);
  }
  if (!job) return std::nullopt;
  return look_at(*job);
}

JobView Jobs::look_at(const Job& job) {
  JobView view;
  {
    const std::lock_guard lock(mutex_);
    view = job.view;
  }
  if (view.state == JobState::kQueued) view.queue_position = dispatcher_.queue_position(job.result_key);
  return view;
}

bool Jobs::watch(const std::string& id, std::uint64_t seen, std::function<void(const JobView&)> changed) {
  JobView view;
  {
    const std::lock_guard lock(mutex_);
    const Shared job = get(id);
    if (!job) return false;
    if (job->view.version <= seen) {
      job->watchers.emplace_back(seen, std::move(changed));
      return true;
    }
    view = job->view;
  }
  changed(view);
  return true;
}

bool Jobs::cancel(const std::string& id) {
  Shared job;
  {
    const std::lock_guard lock(mutex_);
    job = get(id);
    if (!job) return false;
    if (job->view.finished()) {
      forget(index_.at(id));
      return true;
    }
  }
  job->stop.request_stop();  // finishes it, here or where it is being finished just now
  return true;
}

std::shared_ptr<const FractureResult> Jobs::find_result(const std::string& key) {
  const std::lock_guard lock(mutex_);
  for (const Shared& job : jobs_)
    if (job->view.result && job->result_key == key) return job->view.result;
  return nullptr;
}

void Jobs::sweep() {
  const std::lock_guard lock(mutex_);
  make_room();
}

void Jobs::cancel_all() {
  std::vector<Shared> unfinished;
  {
    const std::lock_guard lock(mutex_);
    for (const Shared& job : jobs_)
      if (!job->view.finished()) unfinished.push_back(job);
  }
  for (const Shared& job : unfinished) job->stop.request_stop();
}

void Jobs::drop_watchers() {
  const std::lock_guard lock(mutex_);
  for (const Shared& job : jobs_) job->watchers.clear();
}

JobFigures Jobs::figures() const {
  const std::lock_guard lock(mutex_);
  JobFigures figures = figures_;
  figures.jobs = jobs_.size();
  for (const Shared& job : jobs_) figures.unfinished += !job->view.finished();
  return figures;
}

void Jobs::forget(std::list<Shared>::iterator at) {
  figures_.result_bytes -= bytes_of((*at)->view);
  index_.erase((*at)->view.id);
  jobs_.erase(at);
}

/// Expired ones leave, then the oldest finished ones until the results fit and there is a place for a new
/// job.
void Jobs::make_room() {
  const Clock::time_point now = Clock::now();
  for (auto at = jobs_.begin(); at != jobs_.end();) {
    const auto next = std::next(at);
    const bool finished = (*at)->view.finished();
    if (finished && now - (*at)->finished >= config_.ttl) {
      forget(at);
      ++figures_.expired;
    } else if (finished &&
               (figures_.result_bytes > config_.max_result_bytes || jobs_.size() >= config_.max_jobs)) {
      forget(at);
      ++figures_.evicted;
    }
    at = next;
  }
}

}  // namespace fracture
