// HTTP as a call that waits, for the threads of a bake: over the kept connections of common/exchange, which
// live on a thread of their own.
#pragma once

#include <memory>
#include <stop_token>

#include "common/base/error.hpp"
#include "common/exchange/exchange.hpp"

namespace fracture::bake {

/// Host and port of "http://host", "http://host:8080/", "http://[::1]:8080". kBadParameter for everything
/// else: https is not spoken here, and a path, a query or a user would be lost.
Expected<protocol::ConnectionSettings> parse_server_url(const std::string& url);

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
