// Jobs as JSON.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "server/jobs/job.hpp"

namespace fracture::http {

/// Returns the job in the schema Job of proto/openapi.yaml.
nlohmann::ordered_json describe(const JobView& job, std::string_view request_id);

/// Formats a time as RFC 3339 in UTC, with microseconds.
std::string time_text(std::chrono::sys_time<std::chrono::microseconds> time);
/// Parses the output of time_text(). Returns nothing for any other text.
std::optional<std::chrono::sys_time<std::chrono::microseconds>> time_in(std::string_view text);

}  // namespace fracture::http
