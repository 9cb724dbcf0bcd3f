// Shows jobs to clients: single jobs, lists and changes.
#include <algorithm>
#include <utility>

#include "server/jobs/jobs.hpp"

namespace fracture {

Jobs::Calls Jobs::change(const Shared& job) {
  ++job->view.version;
  Calls calls;
  for (Watcher& watcher : job->watchers)
    calls.push_back([call = std::move(watcher.changed), view = job->view] { call(view); });
  job->watchers.clear();
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
  return look_at(job);
}

JobView Jobs::look_at(const Shared& job) {
  check_result(job);
  std::vector<JobView> view(1);
  {
    const std::lock_guard lock(mutex_);
    view.front() = job->view;
  }
  place(view);
  return std::move(view.front());
}

void Jobs::place(std::vector<JobView>& views) {
  std::vector<JobView*> queued;
  std::vector<std::string> keys;
  for (JobView& view : views) {
    if (view.state != JobState::kQueued) continue;
    queued.push_back(&view);
    keys.push_back(view.result_key);
  }
  if (queued.empty()) return;
  const auto positions = dispatcher_.queue_positions(keys);
  for (std::size_t k = 0; k < queued.size(); ++k) queued[k]->queue_position = positions[k];
}

std::vector<JobView> Jobs::list(const Filter& filter, std::size_t limit) {
  std::vector<JobView> views;
  for (bool again = true; again;) {
    std::vector<Shared> found;
    views.clear();
    {
      const std::lock_guard lock(mutex_);
      make_room();
      for (auto at = jobs_.rbegin(); at != jobs_.rend() && found.size() < limit; ++at) {
        const JobView& view = (*at)->view;
        if (view.created < filter.before && (!filter.state || view.state == *filter.state) &&
            (!filter.sees || filter.sees(view.owner))) {
          found.push_back(*at);
          views.push_back(view);
        }
      }
    }
    // A job whose result was lost may not match any more. Each repetition fails at least one job.
    again = false;
    for (const Shared& job : found) again = check_result(job) || again;
  }
  place(views);
  return views;
}

std::optional<Jobs::WatchId> Jobs::watch(const std::string& id, std::uint64_t seen,
                                         std::function<void(const JobView&)> changed) {
  Shared job;
  {
    const std::lock_guard lock(mutex_);
    job = get(id);
    if (!job) return std::nullopt;
    if (job->view.version <= seen) {
      job->watchers.push_back({next_watch_, std::move(changed)});
      return next_watch_++;
    }
  }
  check_result(job);
  JobView view;
  {
    const std::lock_guard lock(mutex_);
    view = job->view;
  }
  changed(view);
  return 0;
}

void Jobs::unwatch(const std::string& id, WatchId watch) {
  Watcher dropped;  // destroyed after the unlock
  const std::lock_guard lock(mutex_);
  const Shared job = get(id);
  if (!job) return;
  const auto at = std::find_if(job->watchers.begin(), job->watchers.end(),
                               [&](const Watcher& watcher) { return watcher.id == watch; });
  if (at == job->watchers.end()) return;
  dropped = std::move(*at);
  job->watchers.erase(at);
}

void Jobs::drop_watchers() {
  std::vector<Watcher> dropped;
  const std::lock_guard lock(mutex_);
  for (const Shared& job : jobs_) {
    std::move(job->watchers.begin(), job->watchers.end(), std::back_inserter(dropped));
    job->watchers.clear();
  }
}

}  // namespace fracture
