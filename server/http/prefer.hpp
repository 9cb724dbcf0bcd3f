// What a client would rather have (Prefer, RFC 7240).
#pragma once

#include <chrono>
#include <optional>

#include "server/http/request_head.hpp"

namespace fracture::http {

/// Longer waits count as this: proxies close connections on which nothing happens for longer.
inline constexpr std::chrono::seconds kLongestWait{60};

struct Preferences {
  bool respond_async = false;                ///< do not keep the connection waiting for the end of the work
  std::optional<std::chrono::seconds> wait;  ///< but so long; at most kLongestWait
};

/// What is malformed or unknown is ignored, as that RFC wants; of what is given twice, the first counts.
Preferences preferences_of(const RequestHead& head);

/// The field Preference-Applied; empty where none was.
std::string applied(const Preferences& preferences);

}  // namespace fracture::http
