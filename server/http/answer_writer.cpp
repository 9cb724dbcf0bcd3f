#include "server/http/answer_writer.hpp"

#include <algorithm>
#include <cstdint>
#include <ctime>

namespace fracture::http {

namespace bhttp = beast::http;

std::string http_date() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[40];
  return std::string(text, std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &utc));
}

asio::awaitable<bool> write_answer(TimedSocket& connection, const HttpLimits& limits,
                                   const Response& response, const std::string& id, const Fields& more,
                                   bool keep_alive, bool head_only) {
  using Body = bhttp::span_body<const std::uint8_t>;
  auto message = begin_message<Body>(response, id, more, keep_alive);
  message.body() = beast::span<const std::uint8_t>(response.body.data(), response.body.size());
  if (response.status != 304 && response.status != 204 && !response.length_unknown)
    message.content_length(response.body.size());

  bhttp::response_serializer<Body> serializer(message);
  serializer.split(head_only);
  serializer.limit(kMaxWritten);  // otherwise the kernel may copy megabytes at once
  const TimedSocket::Clock::time_point start = TimedSocket::Clock::now();
  std::uint64_t written = 0;
  while (head_only ? !serializer.is_header_done() : !serializer.is_done()) {
    const std::uint64_t waiting = written == 0 ? 0 : connection.unsent();
    const std::uint64_t taken = written - std::min(written, waiting);
    const auto earned =
        std::chrono::milliseconds(1000 * taken / std::max<std::uint64_t>(1, limits.answer_rate));
    connection.set_deadline(
        std::min(start + limits.write_stall + earned, TimedSocket::Clock::now() + limits.write_stall));
    error_code ec;
    written += co_await bhttp::async_write_some(connection.socket(), serializer,
                                                asio::redirect_error(asio::use_awaitable, ec));
    if (ec) {
      connection.clear_deadline();
      co_return false;
    }
  }
  connection.clear_deadline();
  co_return true;
}

}  // namespace fracture::http
