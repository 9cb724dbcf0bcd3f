// Reads the body of one request from the connection and enforces all limits: size, rate, memory and framing
// overhead.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/http/api.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

struct BodyOutcome {
  bool closed = false;  ///< the client left: there is nobody to answer
  std::optional<Problem> problem{};
  std::uint64_t wire_bytes = 0;  ///< as received, including framing
};

/// Reads the body into request.body. `buffer` begins with the request's header of `head_size` bytes, which
/// the framing guard has approved. The header and the body are consumed. Beast's parser reads the header too,
/// and both parsers must agree. The memory is charged to `address` as the bytes arrive, so that merely
/// announcing a large body reserves nothing.
asio::awaitable<BodyOutcome> read_body(TimedSocket& connection, beast::flat_buffer& buffer,
                                       std::size_t head_size, Api& api, Request& request,
                                       const std::string& address);

}  // namespace fracture::http
