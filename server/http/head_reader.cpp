#include "server/http/head_reader.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

namespace fracture::http {
namespace {

using Clock = TimedSocket::Clock;

/// Clients of the admin listener are nearby and fast.
constexpr std::chrono::milliseconds kAdminPatience{5'000};

}  // namespace

asio::awaitable<OrProblem<std::optional<RequestHead>>> read_head(
    TimedSocket& connection, beast::flat_buffer& buffer, const HttpLimits& limits, Listener listener,
    std::size_t& head_size, std::function<bool(bool started)> leave, std::function<void()> begun) {
  using Result = OrProblem<std::optional<RequestHead>>;
  const auto at_most = [listener](std::chrono::milliseconds patience) {
    return listener == Listener::kAdmin ? std::min(patience, kAdminPatience) : patience;
  };
  const std::chrono::milliseconds idle = at_most(limits.idle), whole = at_most(limits.header_timeout);
  std::size_t searched = 0;
  bool started = buffer.size() > 0;
  connection.set_deadline(Clock::now() + (started ? whole : idle));
  if (started) begun();
  for (;;) {
    const std::string_view received(static_cast<const char*>(buffer.cdata().data()), buffer.size());
    OrProblem<std::optional<std::size_t>> end = find_head_end(received, searched, limits);
    if (!end) co_return tl::unexpected<Problem>(std::move(end.error()));
    if (*end) {
      connection.clear_deadline();
      OrProblem<RequestHead> head = parse_head(received.substr(0, **end), limits);
      if (!head) co_return tl::unexpected<Problem>(std::move(head.error()));
      head_size = **end;
      co_return Result(std::optional<RequestHead>(std::move(*head)));
    }
    if (leave(started)) co_return Result(std::nullopt);
    error_code ec;
    const std::size_t room = std::min<std::size_t>(16u << 10, kReadBuffer - buffer.size());
    const std::size_t n = co_await connection.socket().async_read_some(
        buffer.prepare(room), asio::redirect_error(asio::use_awaitable, ec));
    buffer.commit(n);
    if (ec) {
      if (connection.timed_out() && started && !leave(started))
        co_return refuse(HttpProblem::kRequestTimeout,
                         "The header was not complete within " + std::to_string(whole.count()) + " ms.");
      co_return Result(std::nullopt);
    }
    if (!started) {
      started = true;
      begun();
      connection.set_deadline(Clock::now() + whole);
    }
  }
}

}  // namespace fracture::http
