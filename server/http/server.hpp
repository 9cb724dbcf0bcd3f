// Listeners, connections and threads. Two listeners: the public one on 1-2 io threads, the admin one on a
// thread of its own, so that no client can starve the probes. Computing happens on the worker pool, never
// here.
//
// Stopping is in the caller's hands (see server/cli/serve.cpp): set_draining() on the Api, then
// stop_accepting(), then wait until connections() is 0 or patience ends, then cancel_jobs(), then the
// destructor.
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
  std::uint16_t port = 8080;                ///< 0: any free one
  std::string admin_address = "127.0.0.1";  ///< of the admin listener
  std::uint16_t admin_port = 8081;          ///< 0: any free one
  int io_threads = 1;
  tenants::TokenFile tokens{};              ///< empty: nobody is asked for one
  TrustedProxies proxies{};                 ///< believed in what they say of their clients
  std::vector<std::string> cors_origins{};  ///< empty: no page of another origin may ask
  /// Names by which this server is called where no token is required ("*": any), beside addresses and
  /// localhost.
  std::vector<std::string> allowed_hosts{};
};

class HttpServer {
 public:
  /// Binds and starts. Throws std::system_error when an address cannot be bound. Raises the soft limit of
  /// file descriptors to the hard one, and lowers max_connections below it.
  HttpServer(const ServerConfig& config, Api& api);
  /// Closes every connection, joins the threads and waits for the pool to be idle (cancel_jobs() makes that
  /// quick).
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::uint16_t port() const;
  std::uint16_t admin_port() const;

  /// No new connections on the public listener; idle connections close, busy ones answer and close.
  void stop_accepting();
  /// Stops the computation of every request that is still waiting for one: each is answered with 503. Jobs
  /// stop, too: those on the disk go on after a restart, the others are cancelled.
  void cancel_jobs();
  /// From now on these decide who may ask, and whose stream of events goes on; what names have used so far stays
  /// counted.
  void replace_tokens(tenants::TokenFile tokens);
  /// Turns of the io threads that hashed, inflated, parsed or sorted more than kMostInTurn: none, or it is a bug.
  std::uint64_t bulk_turns() const;
  /// Open connections of the public listener.
  std::size_t connections() const;
  /// Public connections that have a request in progress.
  std::size_t requests_in_progress() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fracture::http
