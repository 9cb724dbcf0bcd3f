// One HTTP exchange over one of a few connections that are kept alive. Everything here runs on the client's
// IO thread.
#pragma once

#include <deque>
#include <functional>
#include <memory>

#include "client/protocol/asio.hpp"
#include "client/protocol/protocol.hpp"

namespace fracture::protocol {

struct HttpRequest {
  const char* method = "GET";
  std::string target;
  std::string content_type;
  std::shared_ptr<const std::string> body;  ///< may be null
};

/// How an exchange ended.
struct Exchange {
  enum class Outcome {
    kAnswered,     ///< whatever the status
    kNoServer,     ///< nobody listens, or the name is unknown
    kBroken,       ///< closed or reset before the answer was whole, or what came is not HTTP
    kTimedOut,     ///< at connecting or within answer_timeout
    kTooLarge,     ///< over max_answer_bytes
    kInterrupted,  ///< by interrupt()
  };
  Outcome outcome = Outcome::kInterrupted;
  std::string detail;
  bool began = false;  ///< some of the answer arrived
  int status = 0;
  std::string body, repr_digest, server_timing, retry_after, content_type;
};

/// What a request is waiting for just now, so that it can be told not to.
struct Interruption {
  bool requested = false;
  std::function<void()> wake;  ///< ends the wait; empty where there is none
  void request() {
    requested = true;
    if (wake) wake();
  }
};

class ConnectionPool {
 public:
  ConnectionPool(asio::io_context& io, const Settings& settings) : io_(io), settings_(settings) {}

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

  asio::io_context& io_;
  const Settings& settings_;
  std::deque<ConnectionPtr> idle_;  ///< the last used one at the back
  std::size_t busy_ = 0;
  std::deque<asio::steady_timer*> waiting_;  ///< exchanges without a connection, first come first served
  std::uint64_t made_ = 0;
};

}  // namespace fracture::protocol
