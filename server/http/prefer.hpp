// Preferences of a client (Prefer, RFC 7240).
#pragma once

#include <chrono>
#include <optional>

#include "server/http/request_head.hpp"

namespace fracture::http {

/// Longest wait; longer ones are shortened to this, because proxies close connections that are idle for
/// longer.
inline constexpr std::chrono::seconds kLongestWait{60};

struct Preferences {
  bool respond_async = false;                ///< answer before the work has ended
  std::optional<std::chrono::seconds> wait;  ///< but wait this long first; at most kLongestWait
};

/// Parses the field. Malformed and unknown preferences are ignored, as the RFC requires; of duplicates, the
/// first counts.
Preferences preferences_of(const RequestHead& head);

/// Returns the field Preference-Applied, or an empty string if none was applied.
std::string applied(const Preferences& preferences);

}  // namespace fracture::http
