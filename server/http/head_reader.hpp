// Reads the header of the next request from a connection, within the time limits.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "server/http/limits.hpp"
#include "server/http/request_head.hpp"
#include "server/http/routes.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// Reads until `buffer` begins with a complete header, whose size is stored in `head_size`. Calls `begun` at
/// the first byte. Returns nothing if the client closed the connection or sent no byte in time, or if `leave`
/// returns true. The argument of `leave` says whether a byte has arrived.
asio::awaitable<OrProblem<std::optional<RequestHead>>> read_head(
    TimedSocket& connection, beast::flat_buffer& buffer, const HttpLimits& limits, Listener listener,
    std::size_t& head_size, std::function<bool(bool started)> leave, std::function<void()> begun);

}  // namespace fracture::http
