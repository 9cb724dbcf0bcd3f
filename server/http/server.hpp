// Listeners, connections and threads. The public listener uses one or two io threads. The admin listener has
// its own thread, so that no client can starve the probes. Computations run on the worker pool, never here.
//
// The caller controls the shutdown (see server/cli/serve.cpp): set_draining() on the Api, then
// stop_accepting(), then wait until connections() is 0 or a time limit has passed, then cancel_jobs(), then
// the destructor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/http/api.hpp"
#include "server/http/auth.hpp"
#include "server/http/client_address.hpp"

namespace fracture::http {

struct ServerConfig {
  std::string address = "127.0.0.1";        ///< numeric IPv4 or IPv6 address of the public listener
  std::uint16_t port = 8080;                ///< 0: any free port
  std::string admin_address = "127.0.0.1";  ///< of the admin listener
  std::uint16_t admin_port = 8081;          ///< 0: any free port
  int io_threads = 1;
  tenants::TokenFile tokens{};              ///< empty: no token is required
  TrustedProxies proxies{};                 ///< trusted to name their clients
  std::vector<std::string> cors_origins{};  ///< empty: no cross-origin requests
  /// Host names of this server that are accepted if no token is required, in addition to addresses and
  /// localhost. "*": any.
  std::vector<std::string> allowed_hosts{};
};

class HttpServer {
 public:
  /// Binds and starts. Throws std::system_error if an address cannot be bound. Raises the soft limit on file
  /// descriptors to the hard limit, and lowers max_connections to fit below it.
  HttpServer(const ServerConfig& config, Api& api);
  /// Closes every connection, joins the threads and waits for the pool to become idle. Call cancel_jobs()
  /// first to make that quick.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::uint16_t port() const;
  std::uint16_t admin_port() const;

  /// Stops accepting public connections. Idle connections are closed; busy ones answer first.
  void stop_accepting();
  /// Stops the computations of all waiting requests, which are answered with 503. Jobs stop, too: those on
  /// disk continue after a restart, the others are cancelled.
  void cancel_jobs();
  /// Replaces the tokens for new requests and for running event streams. The counted usage of each name is
  /// kept.
  void replace_tokens(tenants::TokenFile tokens);
  /// Number of io turns that hashed, inflated, parsed or sorted more than kMostInTurn. Anything but 0 is a
  /// bug.
  std::uint64_t bulk_turns() const;
  /// Number of open connections of the public listener.
  std::size_t connections() const;
  /// Number of public connections with a request in progress.
  std::size_t requests_in_progress() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fracture::http
