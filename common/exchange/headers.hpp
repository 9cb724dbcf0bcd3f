// Parses header fields of an answer. No network.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

/// One entry of Server-Timing.
struct StageTime {
  std::string name;
  double milliseconds = 0;
};

/// Parses Server-Timing (W3C): `queue;dur=0.1, clip;dur=3.25`. Unknown parts are left out.
std::vector<StageTime> parse_server_timing(std::string_view value);

/// Parses Retry-After in whole seconds (RFC 9110, 10.2.3). Returns nothing for dates, malformed values, or
/// more than a day.
std::optional<Milliseconds> parse_retry_after(std::string_view value);

/// Whether Repr-Digest (RFC 9530) contains the SHA-256 of these bytes. False if the field has no sha-256.
bool digest_matches(std::string_view repr_digest, std::string_view bytes);

}  // namespace fracture::protocol
