// Blocking HTTP calls for the threads of a bake, made over the keep-alive connections of common/exchange,
// which run on their own thread.
#pragma once

#include <memory>
#include <stop_token>

#include "common/base/error.hpp"
#include "common/exchange/exchange.hpp"

namespace fracture::bake {

/// Parses the host and port from "http://host", "https://host:8443/" or "http://[::1]:8080". With https, the
/// certificate authorities are those in the PEM file `ca_file`, or the system's if `ca_file` is empty.
/// Returns kBadParameter for anything else: a path, a query or a user name would be ignored.
Expected<protocol::ConnectionSettings> parse_server_url(const std::string& url,
                                                        const std::string& ca_file = {});

class HttpCaller {
 public:
  explicit HttpCaller(const protocol::ConnectionSettings& settings);
  /// No call may be in progress.
  ~HttpCaller();
  HttpCaller(const HttpCaller&) = delete;
  HttpCaller& operator=(const HttpCaller&) = delete;

  /// Makes one call. Thread-safe. Returns kInterrupted shortly after a stop is requested.
  protocol::Exchange exchange(const protocol::HttpRequest& request, const std::stop_token& stop);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture::bake
