// Reads the PROXY protocol, in which a trusted proxy names its client before the first request.
#pragma once

#include <optional>
#include <string>

#include "server/http/asio.hpp"
#include "server/http/client_address.hpp"
#include "server/http/limits.hpp"
#include "server/http/problem.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// Reads the header, if there is one, and removes it from `buffer`; later bytes stay there. Returns the
/// client's address, which is empty if the proxy gives none. Returns 400 if the header is malformed, and
/// nothing if the connection is closed or silent for too long.
asio::awaitable<std::optional<OrProblem<std::string>>> read_proxy_header(TimedSocket& connection,
                                                                         beast::flat_buffer& buffer,
                                                                         const HttpLimits& limits);

}  // namespace fracture::http
