// HTTP as a call that waits, for the threads of a bake: over the kept connections of common/exchange, which
// live on a thread of their own.
#pragma once

#include <memory>
#include <stop_token>

#include "common/base/error.hpp"
#include "common/exchange/exchange.hpp"

namespace fracture::bake {

/// Host and port of "http://host", "https://host:8443/", "http://[::1]:8080"; for https with those whom the
/// PEM file names, or where it is empty the system. kBadParameter for everything else: a path, a query or a
/// user would be lost.
Expected<protocol::ConnectionSettings> parse_server_url(const std::string& url,
                                                        const std::string& ca_file = {});

class HttpCaller {
 public:
  explicit HttpCaller(const protocol::ConnectionSettings& settings);
  /// No call may be waiting.
  ~HttpCaller();
  HttpCaller(const HttpCaller&) = delete;
  HttpCaller& operator=(const HttpCaller&) = delete;

  /// Thread-safe. kInterrupted soon after the stop.
  protocol::Exchange exchange(const protocol::HttpRequest& request, const std::stop_token& stop);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture::bake
