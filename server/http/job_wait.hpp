// Waiting for the end of a job, on no thread.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "server/jobs/jobs.hpp"
#include "server/service/timer.hpp"

namespace fracture::http {

/// Calls `then` once, now or later from any thread, with the job as it is when it has finished, when `until`
/// is there or when `gone` is stopped, whichever comes first; with nothing where it is not known (any more).
void wait_for_job(Jobs& jobs, Timer& timer, const std::string& id, Timer::Clock::time_point until,
                  const std::stop_token& gone, std::function<void(std::optional<JobView>)> then);

}  // namespace fracture::http
