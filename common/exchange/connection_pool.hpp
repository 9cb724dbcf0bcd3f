// HTTP exchanges over a few keep-alive connections. All functions run on the thread of the io_context.
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

  /// Sends the request and reads the whole answer. If the server has closed an idle connection in the
  /// meantime, it is replaced once, silently.
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
  /// Returns false and describes the reason in `exchange`.
  asio::awaitable<bool> connect(Connection& connection, Exchange& exchange);
  asio::awaitable<bool> shake_hands(Connection& connection, Exchange& exchange);
  ConnectionPtr take_idle();

  asio::io_context& io_;
  const ConnectionSettings settings_;
  std::deque<ConnectionPtr> idle_;  ///< the most recently used one at the back
  std::size_t busy_ = 0;
  std::deque<asio::steady_timer*> waiting_;  ///< exchanges that wait for a connection, in order of arrival
  std::uint64_t made_ = 0;
};

}  // namespace fracture::protocol
