// Calls a server, or a farm behind a proxy, and retries while it is absent, restarting or busy, until the
// patience limit is reached.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>

#include "common/exchange/problem_document.hpp"
#include "server/bake/http_caller.hpp"

namespace fracture::bake {

struct Patience {
  std::chrono::milliseconds total{60'000};  ///< if no thread gets a good answer for this long, all calls fail
  std::chrono::milliseconds first_pause{50};       ///< before the first retry; doubles each time …
  std::chrono::milliseconds longest_pause{2'000};  ///< … up to this. A longer Retry-After takes precedence.
};

/// Returns the problem in an answer. If the media type is not that of problem documents, as in a proxy's
/// answer, the body is ignored.
protocol::ProblemDocument problem_of(const protocol::Exchange& exchange);

/// Thread-safe.
class PatientCaller {
 public:
  PatientCaller(const protocol::ConnectionSettings& settings, const Patience& patience);

  /// Sends a request, and retries it if the server cannot be reached, and after 408, 429, 502, 503 and a 504
  /// from a proxy. A 504 from the server itself is an answer: the deadline has passed. Returns kUnavailable
  /// after 401 or 403 or when patience is used up; all later calls then fail too. Also returns kTooLarge and
  /// kCancelled.
  Expected<protocol::Exchange> ask(const protocol::HttpRequest& request, const std::stop_token& stop);
  /// Sends a request once and ignores the result.
  void tell(const protocol::HttpRequest& request) { caller_.exchange(request, {}); }
  /// Waits until the time has passed, a stop is requested, or all calls have given up.
  void pause(std::chrono::milliseconds time, const std::stop_token& stop);
  void on_notice(std::function<void(const std::string&)> say) { say_ = std::move(say); }
  const Patience& patience() const { return patience_; }

 private:
  using Clock = std::chrono::steady_clock;
  Error give_up(const std::string& detail);
  void heard();
  /// Returns how much longer a call that began at `begun` may retry. Reports once per outage that the server
  /// is being waited for.
  std::chrono::milliseconds hope(Clock::time_point begun, bool busy, const std::string& trouble);

  const std::string server_;  ///< "host:port", for messages
  const Patience patience_;
  HttpCaller caller_;
  std::function<void(const std::string&)> say_ = [](const std::string&) {};
  std::mutex mutex_;
  std::condition_variable_any changed_;
  Clock::time_point heard_ = Clock::now();
  bool trouble_said_ = false;
  std::string gave_up_;  ///< the reason; empty if calls have not given up
};

}  // namespace fracture::bake
