#include "server/http/proxied.hpp"

#include <utility>

namespace fracture::http {

asio::awaitable<std::optional<OrProblem<std::string>>> read_proxy_header(TimedSocket& connection,
                                                                         beast::flat_buffer& buffer,
                                                                         const HttpLimits& limits) {
  using Result = std::optional<OrProblem<std::string>>;
  constexpr std::size_t kAtOnce = 4096;
  connection.set_deadline(TimedSocket::Clock::now() + limits.idle);
  for (bool started = false;;) {
    const std::string_view received(static_cast<const char*>(buffer.cdata().data()), buffer.size());
    ProxyHeader header = parse_proxy_header(received);
    if (!received.empty() && header.state != ProxyHeader::State::kIncomplete) {
      connection.clear_deadline();
      if (header.state == ProxyHeader::State::kMalformed)
        co_return Result(refuse(HttpProblem::kMalformedRequest, "The PROXY protocol header is malformed."));
      buffer.consume(header.size);
      co_return Result(OrProblem<std::string>(std::move(header.address)));
    }
    boost::system::error_code ec;
    const std::size_t n = co_await connection.socket().async_read_some(
        buffer.prepare(kAtOnce), asio::redirect_error(asio::use_awaitable, ec));
    buffer.commit(n);
    if (ec) co_return Result();
    if (!std::exchange(started, true))
      connection.set_deadline(TimedSocket::Clock::now() + limits.header_timeout);
  }
}

}  // namespace fracture::http
