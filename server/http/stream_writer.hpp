// Writes an answer whose bytes come while it is written.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/http/answer_head.hpp"
#include "server/http/limits.hpp"
#include "server/http/work_wait.hpp"

namespace fracture::http {

/// What one streamed answer needs of its connection. It and what it refers to outlive the writing.
struct StreamTarget {
  TimedSocket& connection;
  std::shared_ptr<WorkWait> wait;
  const HttpLimits& limits;
  std::function<bool()> draining;  ///< the server stops: the stream ends here
  std::function<bool()> allowed;   ///< false: its reader may read no more: the stream is cut off
};

/// What the stream delivers, until it ends, the server drains or its reader may read no more; in chunks, or (a client of HTTP/1.0 knows none)
/// as it is: then the answer ends with the connection. False when the client is gone, takes it too slowly or
/// may read no more: then nothing is sent that would end the answer.
asio::awaitable<bool> write_stream(const StreamTarget& target, const Response& response,
                                   const std::string& id, const Fields& more, bool chunked, bool keep_alive,
                                   bool head_only);

}  // namespace fracture::http
