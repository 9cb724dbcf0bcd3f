// A job as JSON.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "server/jobs/job.hpp"

namespace fracture::http {

/// The schema Job of proto/openapi.yaml.
nlohmann::ordered_json describe(const JobView& job, std::string_view request_id);

/// RFC 3339 in UTC, with all of its microseconds.
std::string time_text(std::chrono::sys_time<std::chrono::microseconds> time);
/// What time_text() wrote; nothing for anything else.
std::optional<std::chrono::sys_time<std::chrono::microseconds>> time_in(std::string_view text);

}  // namespace fracture::http
