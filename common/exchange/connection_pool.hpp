// One HTTP exchange over one of a few connections that are kept alive. Everything here runs on the
// thread of the io_context.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "common/exchange/asio.hpp"
#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

class ConnectionPool {
 public:
  ConnectionPool(asio::io_context& io, ConnectionSettings settings)
      : io_(io), settings_(std::move(settings)) {}

  /// Sends the request and reads the whole answer. A kept connection that the server had closed in the
  /// meantime is replaced once, unseen.
  asio::awaitable<Exchange> exchange(const HttpRequest& request, Interruption& interruption);

  /// Waits, unless interrupted.
  asio::awaitable<void> pause(Milliseconds time, Interruption& interruption);

  void close_idle() { idle_.clear(); }
  std::uint64_t connections_made() const { return made_; }

 private:
  struct Connection {
    explicit Connection(asio::io_context& io) : stream(io) {}
    beast::tcp_stream stream;
    beast::flat_buffer buffer;
    std::chrono::steady_clock::time_point used;
  };
  using ConnectionPtr = std::unique_ptr<Connection>;

  asio::awaitable<Exchange> attempt(const HttpRequest& request, ConnectionPtr& connection,
                                    Interruption& interruption);
  /// False with the reason in `exchange`.
  asio::awaitable<bool> connect(Connection& connection, Exchange& exchange);
  ConnectionPtr take_idle();
  std::string authority() const;

  asio::io_context& io_;
  const ConnectionSettings settings_;
  std::deque<ConnectionPtr> idle_;  ///< the last used one at the back
  std::size_t busy_ = 0;
  std::deque<asio::steady_timer*> waiting_;  ///< exchanges without a connection, first come first served
  std::uint64_t made_ = 0;
};

}  // namespace fracture::protocol
