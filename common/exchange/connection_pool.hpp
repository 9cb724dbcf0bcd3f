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
  ConnectionPool(asio::io_context& io, ConnectionSettings settings);
  ~ConnectionPool();
  ConnectionPool(const ConnectionPool&) = delete;
  ConnectionPool& operator=(const ConnectionPool&) = delete;

  /// Sends the request and reads the whole answer. A kept connection that the server had closed in the
  /// meantime is replaced once, unseen.
  asio::awaitable<Exchange> exchange(const HttpRequest& request, Interruption& interruption);

  /// Waits, unless interrupted.
  asio::awaitable<void> pause(Milliseconds time, Interruption& interruption);

  void close_idle();
  std::uint64_t connections_made() const { return made_; }

 private:
  struct Connection;
  using ConnectionPtr = std::unique_ptr<Connection>;

  asio::awaitable<Exchange> attempt(const HttpRequest& request, ConnectionPtr& connection,
                                    Interruption& interruption);
  /// False with the reason in `exchange`.
  asio::awaitable<bool> connect(Connection& connection, Exchange& exchange);
  asio::awaitable<bool> shake_hands(Connection& connection, Exchange& exchange);
  ConnectionPtr take_idle();

  asio::io_context& io_;
  const ConnectionSettings settings_;
  std::deque<ConnectionPtr> idle_;  ///< the last used one at the back
  std::size_t busy_ = 0;
  std::deque<asio::steady_timer*> waiting_;  ///< exchanges without a connection, first come first served
  std::uint64_t made_ = 0;
};

}  // namespace fracture::protocol
