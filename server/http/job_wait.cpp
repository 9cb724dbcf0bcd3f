#include "server/http/job_wait.hpp"

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

namespace fracture::http {
namespace {

/// Kept alive by the timer and the job's watch, which both release it at the end.
class Wait : public std::enable_shared_from_this<Wait> {
 public:
  Wait(Jobs& jobs, Timer& timer, std::string id, std::function<void(std::optional<JobView>)> then)
      : jobs_(jobs), timer_(timer), id_(std::move(id)), then_(std::move(then)) {}

  void begin(Timer::Clock::time_point until, const std::stop_token& gone) {
    look(0);
    if (ended_) return;
    const Timer::Id alarm = timer_.at(until, [self = shared_from_this()] { self->end(); });
    {
      const std::lock_guard lock(mutex_);
      alarm_ = alarm;
    }
    if (ended_) timer_.cancel(alarm);  // the wait ended in between and did not see the alarm
    gone_.emplace(gone, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->end();
    });
  }

 private:
  void look(std::uint64_t seen) {
    const auto watch = jobs_.watch(id_, seen, [self = shared_from_this()](const JobView& job) {
      if (job.finished())
        self->end(job);
      else if (!self->ended_)
        self->look(job.version);
    });
    if (!watch) return end();
    if (*watch == 0) return;
    watch_ = *watch;
    if (ended_) jobs_.unwatch(id_, *watch);
  }

  void end(std::optional<JobView> job = std::nullopt) {
    if (ended_.exchange(true)) return;
    std::optional<Timer::Id> alarm;
    {
      const std::lock_guard lock(mutex_);
      alarm = alarm_;
    }
    if (alarm) timer_.cancel(*alarm);
    jobs_.unwatch(id_, watch_);
    then_(job ? std::move(job) : jobs_.find(id_));
  }

  Jobs& jobs_;
  Timer& timer_;
  const std::string id_;
  const std::function<void(std::optional<JobView>)> then_;
  std::atomic<bool> ended_{false};
  std::atomic<Jobs::WatchId> watch_{0};
  std::mutex mutex_;
  std::optional<Timer::Id> alarm_;
  std::optional<std::stop_callback<std::function<void()>>> gone_;
};

}  // namespace

void wait_for_job(Jobs& jobs, Timer& timer, const std::string& id, Timer::Clock::time_point until,
                  const std::stop_token& gone, std::function<void(std::optional<JobView>)> then) {
  std::make_shared<Wait>(jobs, timer, id, std::move(then))->begin(until, gone);
}

}  // namespace fracture::http
