// Reads the header of the next request from a connection, in the time there is for it.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "server/http/limits.hpp"
#include "server/http/request_head.hpp"
#include "server/http/routes.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// Reads until a whole header is at the front of `buffer`, `head_size` bytes long. Nothing: the client closed
/// or stayed idle without having sent a byte, or `leave` (told whether a byte has come) says that it is not
/// waited for any longer. Calls `begun` at its first byte.
asio::awaitable<OrProblem<std::optional<RequestHead>>> read_head(
    TimedSocket& connection, beast::flat_buffer& buffer, const HttpLimits& limits, Listener listener,
    std::size_t& head_size, std::function<bool(bool started)> leave, std::function<void()> begun);

}  // namespace fracture::http
