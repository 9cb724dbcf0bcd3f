// The header fields of an answer, as values. No network.
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

/// Server-Timing (W3C): `queue;dur=0.1, clip;dur=3.25`. What is not understood is left out.
std::vector<StageTime> parse_server_timing(std::string_view value);

/// Retry-After in whole seconds (RFC 9110, 10.2.3); nothing for a date or nonsense, or beyond a day.
std::optional<Milliseconds> parse_retry_after(std::string_view value);

/// Does Repr-Digest (RFC 9530) name the SHA-256 of these bytes? False for a field without sha-256.
bool digest_matches(std::string_view repr_digest, std::string_view bytes);

}  // namespace fracture::protocol
