// The log: lines on standard error, as JSON for programs or as text for people. Logging never blocks: lines
// go through a bounded queue to a separate thread. If standard error is not read, the oldest lines are
// dropped and counted.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "server/ops/request_record.hpp"

namespace fracture::ops {

enum class LogFormat { kText, kJson };

/// Starts the log. Call once, before the first line. From then on, spdlog's own functions (spdlog::info …)
/// use this format too. `level` is a level name of spdlog. JSON lines have `time` (RFC 3339, UTC), `level`,
/// and either `message` or `event` with its fields.
void start_logging(LogFormat format, const std::string& level);

/// Waits until everything is written. Returns false if this takes longer than `patience`, because standard
/// error is not read. The process should then end with std::_Exit, because the logging thread cannot be
/// joined.
bool stop_logging(std::chrono::milliseconds patience);

/// Number of lines that were dropped.
std::uint64_t dropped_log_lines();

/// Logs a structured line: `event` and the fields of the object.
void log_event(std::string_view event, const nlohmann::ordered_json& fields);

/// Logs a request. Requests on the admin listener are only logged at level debug.
void log_request(const RequestRecord& record);
/// Logs which name changed or created something: an `audit` line for each request with a token that is not
/// GET or HEAD, even if it was refused.
void log_audit(const RequestRecord& record);

}  // namespace fracture::ops
