#include "server/http/stream_writer.hpp"

#include <optional>
#include <utility>

namespace fracture::http {
namespace {

using std::chrono::steady_clock;
namespace bhttp = beast::http;

/// Data from the stream. Shared, because either side may outlive the other.
struct Next {
  bool there = false;
  std::optional<std::string> bytes;  // empty: the stream has ended
};

/// Waits for the next data. Returns an empty Next if the client is gone, the server is draining or reading is
/// not allowed.
asio::awaitable<std::shared_ptr<Next>> next_of(BodyStream& stream, const StreamTarget& target) {
  const auto next = std::make_shared<Next>();
  target.wait->begin();
  const auto executor = target.connection.socket().get_executor();
  stream.next([weak = std::weak_ptr(target.wait), executor, next](std::optional<std::string> bytes) {
    asio::dispatch(executor, [weak, next, bytes = std::move(bytes)]() mutable {
      next->there = true;
      next->bytes = std::move(bytes);
      if (const auto wait = weak.lock()) wait->wake();
    });
  });
  const std::function<bool()> over = [&] {
    return next->there || target.draining() || !target.allowed() || target.wait->stopped();
  };
  co_await target.wait->until(over);
  co_return next;
}

}  // namespace

asio::awaitable<bool> write_stream(const StreamTarget& target, const Response& response,
                                   const std::string& id, const Fields& more, bool chunked, bool keep_alive,
                                   bool head_only) {
  tcp::socket& socket = target.connection.socket();
  auto message = begin_message<bhttp::empty_body>(response, id, more, keep_alive);
  message.chunked(chunked);
  bhttp::response_serializer<bhttp::empty_body> serializer(message);
  error_code ec;
  const auto into_ec = [&ec] { return asio::redirect_error(asio::use_awaitable, ec); };
  target.connection.set_deadline(steady_clock::now() + target.limits.write_stall);
  co_await bhttp::async_write_header(socket, serializer, into_ec());
  while (!ec && !head_only) {
    target.connection.clear_deadline();
    const std::shared_ptr<Next> next = co_await next_of(*response.stream, target);
    if (target.wait->stopped() || !target.allowed()) co_return false;
    const bool last = !next->there || !next->bytes;
    if (last && !chunked) break;
    target.connection.set_deadline(steady_clock::now() + target.limits.write_stall);
    // The chunks are variables: g++ 12 destroys a temporary in the arguments of an awaited call twice.
    if (last) {
      const auto end = bhttp::make_chunk_last();
      co_await asio::async_write(socket, end, into_ec());
      break;
    }
    const asio::const_buffer bytes(next->bytes->data(), next->bytes->size());
    if (chunked) {
      const auto chunk = bhttp::make_chunk(bytes);
      co_await asio::async_write(socket, chunk, into_ec());
    } else {
      co_await asio::async_write(socket, bytes, into_ec());
    }
  }
  target.connection.clear_deadline();
  co_return !ec;
}

}  // namespace fracture::http
