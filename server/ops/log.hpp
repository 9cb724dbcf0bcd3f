// The log: lines on standard error, JSON for machines or text for people. Whoever logs never waits: the lines
// go through a bounded queue to a thread of their own, and when nobody reads them the oldest are dropped and
// counted.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "server/ops/request_record.hpp"

namespace fracture::ops {

enum class LogFormat { kText, kJson };

/// Once, before the first line. From then on spdlog's own functions (spdlog::info …) write in this format,
/// too. `level` is one of spdlog's names. JSON lines have `time` (RFC 3339, UTC), `level`, and either
/// `message` or `event` with its fields.
void start_logging(LogFormat format, const std::string& level);

/// Waits until everything is written. False when that takes longer than `patience`, because nobody reads
/// standard error; the process should then end by std::_Exit, since the logging thread cannot be joined.
bool stop_logging(std::chrono::milliseconds patience);

/// Lines that were never written.
std::uint64_t dropped_log_lines();

/// A structured line: `event` and the fields of the object.
void log_event(std::string_view event, const nlohmann::ordered_json& fields);

/// The access line; of the admin listener only at level debug.
void log_request(const RequestRecord& record);
/// Who changed or made what, under tokens: an `audit` line for each request that is no GET or HEAD, refused
/// ones included.
void log_audit(const RequestRecord& record);

}  // namespace fracture::ops
