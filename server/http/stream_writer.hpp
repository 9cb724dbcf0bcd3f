// Writes an answer whose data arrives while it is being written.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/http/answer_head.hpp"
#include "server/http/limits.hpp"
#include "server/http/work_wait.hpp"

namespace fracture::http {

/// The objects that a streamed answer needs. They must outlive the writing.
struct StreamTarget {
  TimedSocket& connection;
  std::shared_ptr<WorkWait> wait;
  const HttpLimits& limits;
  std::function<bool()> draining;  ///< true if the server is stopping: the stream ends normally
  std::function<bool()> allowed;   ///< false if the reader lost its permission: the stream is cut off
};

/// Writes the stream. It ends early if the server is draining, or if the reader has lost its permission. The
/// data is sent in chunks or, for HTTP/1.0, unframed, and the answer then ends with the connection. Returns false
/// if the client is gone, reads too slowly or lost its permission; the answer is then left without its end.
asio::awaitable<bool> write_stream(const StreamTarget& target, const Response& response,
                                   const std::string& id, const Fields& more, bool chunked, bool keep_alive,
                                   bool head_only);

}  // namespace fracture::http
