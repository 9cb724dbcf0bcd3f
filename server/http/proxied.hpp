// The PROXY protocol on a connection: whom a trusted proxy speaks for, before its first request.
#pragma once

#include <optional>
#include <string>

#include "server/http/asio.hpp"
#include "server/http/client_address.hpp"
#include "server/http/limits.hpp"
#include "server/http/problem.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// Reads the header, where there is one, and takes it out of `buffer`; what came after it stays there. The
/// client's address; empty where the proxy says none. 400 for a malformed one, nothing when the connection is
/// closed or silent for too long.
asio::awaitable<std::optional<OrProblem<std::string>>> read_proxy_header(TimedSocket& connection,
                                                                         beast::flat_buffer& buffer,
                                                                         const HttpLimits& limits);

}  // namespace fracture::http
