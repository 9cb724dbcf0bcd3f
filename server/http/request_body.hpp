// Reads one request's body from the connection, under every limit there is: size, rate, memory, and what the
// framing may cost.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/http/api.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

struct BodyOutcome {
  bool closed = false;  ///< the client went away: there is nobody to answer
  std::optional<Problem> problem{};
  std::uint64_t wire_bytes = 0;  ///< as received, framing included
};

/// `buffer` begins with the request's header of `head_size` bytes, which the guard has approved; it is
/// consumed, and so is the body, which ends in request.body. The header goes through Beast's parser too: two
/// opinions that must agree.
/// The memory it takes is the address's, charged as the bytes arrive: what is only announced holds nothing.
asio::awaitable<BodyOutcome> read_body(TimedSocket& connection, beast::flat_buffer& buffer,
                                       std::size_t head_size, Api& api, Request& request,
                                       const std::string& address);

}  // namespace fracture::http
