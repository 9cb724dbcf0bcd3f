// Asks a server, or a farm behind a proxy, as long as there is hope: while it is absent, restarts or is busy,
// the question is asked again.
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
  std::chrono::milliseconds total{60'000};    ///< without any good answer, to anybody; then all calls give up
  std::chrono::milliseconds first_pause{50};  ///< before asking again; doubles …
  std::chrono::milliseconds longest_pause{2'000};  ///< … up to this. Where Retry-After says more, that long.
};

/// Of an answer of the server itself: a proxy's body, which is no problem document by its media type, says nothing.
protocol::ProblemDocument problem_of(const protocol::Exchange& exchange);

/// Thread-safe.
class PatientCaller {
 public:
  PatientCaller(const protocol::ConnectionSettings& settings, const Patience& patience);

  /// Every status but 429, 502, 503 and 504 of a proxy and 408 is an answer; so is a 504 of the server
  /// itself, whose deadline passed. kUnavailable after all patience, at 401 and 403, and for whoever asks
  /// after that; kTooLarge; kCancelled.
  Expected<protocol::Exchange> ask(const protocol::HttpRequest& request, const std::stop_token& stop);
  /// One try, whatever comes of it.
  void tell(const protocol::HttpRequest& request) { caller_.exchange(request, {}); }
  /// Waits, not longer than until the stop comes or everybody gives up.
  void pause(std::chrono::milliseconds time, const std::stop_token& stop);
  void on_notice(std::function<void(const std::string&)> say) { say_ = std::move(say); }
  const Patience& patience() const { return patience_; }

 private:
  using Clock = std::chrono::steady_clock;
  Error give_up(const std::string& detail);
  void heard();
  /// How long there still is hope for one who has asked since `begun`; says, once an outage, that it is
  /// waited for.
  std::chrono::milliseconds hope(Clock::time_point begun, bool busy, const std::string& trouble);

  const std::string server_;  ///< "host:port", for words
  const Patience patience_;
  HttpCaller caller_;
  std::function<void(const std::string&)> say_ = [](const std::string&) {};
  std::mutex mutex_;
  std::condition_variable_any changed_;
  Clock::time_point heard_ = Clock::now();
  bool trouble_said_ = false;
  std::string gave_up_;  ///< why; empty: nobody did
};

}  // namespace fracture::bake
