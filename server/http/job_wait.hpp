// Waits for the end of a job without occupying a thread.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "server/jobs/jobs.hpp"
#include "server/service/timer.hpp"

namespace fracture::http {

/// Calls `then` exactly once, now or later, from any thread: when the job has finished, at `until`, or when
/// `gone` is stopped, whichever comes first. Passes the job in its current state, or nothing if the job is
/// not known (any more).
void wait_for_job(Jobs& jobs, Timer& timer, const std::string& id, Timer::Clock::time_point until,
                  const std::stop_token& gone, std::function<void(std::optional<JobView>)> then);

}  // namespace fracture::http
