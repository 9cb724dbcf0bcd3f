// Writes a complete answer without copying it, and requires a minimum speed of the client.
#pragma once

#include <string>

#include "server/http/answer_head.hpp"
#include "server/http/limits.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// Writes an answer. Returns false if the client is gone, took nothing for write_stall, or took less than
/// answer_rate on average after that time. Bytes that wait in the socket do not count as taken.
asio::awaitable<bool> write_answer(TimedSocket& connection, const HttpLimits& limits,
                                   const Response& response, const std::string& id, const Fields& more,
                                   bool keep_alive, bool head_only);

}  // namespace fracture::http
