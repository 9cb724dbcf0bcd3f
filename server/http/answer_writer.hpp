// Writes an answer whose bytes are all there, without a copy, at the pace that a client has to keep.
#pragma once

#include <string>

#include "server/http/answer_head.hpp"
#include "server/http/limits.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// False when the client is gone, took nothing for write_stall, or after that took less than answer_rate on
/// average. What waits in the socket counts as not taken.
asio::awaitable<bool> write_answer(TimedSocket& connection, const HttpLimits& limits,
                                   const Response& response, const std::string& id, const Fields& more,
                                   bool keep_alive, bool head_only);

}  // namespace fracture::http
