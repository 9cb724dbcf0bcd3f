// What the server answers. Knows HTTP's meaning but no sockets: a session hands it the header (admit), then
// the whole request (start), and writes what comes back. The handlers stand in one file for each subject:
// api_fracture.cpp, api_results.cpp, api_discovery.cpp; admit.cpp decides from the header alone.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/limits.hpp"
#include "server/http/message.hpp"
#include "server/http/routes.hpp"
#include "server/service/dispatcher.hpp"
#include "server/service/memory_budget.hpp"
#include "server/service/service.hpp"

namespace fracture::http {

/// What a handler has to say: an answer, or nothing yet (it replies later), or a refusal.
using Answered = OrProblem<std::optional<Response>>;

class Api {
 public:
  using Reply = std::function<void(Response)>;

  Api(Dispatcher& dispatcher, const HttpLimits& limits)
      : dispatcher_(dispatcher),
        service_(dispatcher.service()),
        limits_(limits),
        bodies_(limits.max_bodies) {}

  /// Decides from the header alone, before any of the body is read: 404, 405, 406, 413, 415, bad parameters
  /// in the query, no room in the queue.
  OrProblem<Admission> admit(Listener listener, const RequestHead& head) const;

  /// Answers through `reply`, which is called exactly once: before this returns or later, from any thread. A
  /// stop of `gone` says that nobody waits for the answer any more. A broken invariant becomes a 500 problem
  /// and a log line.
  void start(std::shared_ptr<Request> request, std::stop_token gone, Reply reply);
  /// Returns when nothing is computed any more and no reply is outstanding.
  void wait_idle() { dispatcher_.wait_idle(); }

  void set_draining() { draining_ = true; }
  bool draining() const { return draining_; }
  Problem no_memory() const;
  MemoryBudget& bodies() { return bodies_; }
  const HttpLimits& limits() const { return limits_; }

 private:
  /// Runs a handler and replies with what it returns, if anything; exceptions become problems.
  void answering(const Request& request, const Reply& reply,
                 const std::function<Answered()>& handle) noexcept;
  Answered dispatch(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);

  Answered post_fracture(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                         const Reply& reply);
  /// What every way to ask for a fracture ends in.
  Answered fracture(const std::shared_ptr<Request>& request, FractureRequest asked, const Terms& terms,
                    const Reply& reply);
  OrProblem<Response> get_fracture(const Request& request);
  Response get_index() const;
  Response get_version() const;
  Response get_limits() const;
  Response get_openapi() const;
  OrProblem<Response> get_readyz() const;
  std::optional<Problem> refuse_media_type(const RequestHead& head, const Admission& admission) const;

  /// Deadline and class of a request, from its header.
  OrProblem<Terms> terms_of(const RequestHead& head, const Route& route) const;
  std::optional<Problem> refuse_overload(const RequestHead& head, const Admission& admission) const;

  Dispatcher& dispatcher_;
  FractureService& service_;
  const HttpLimits limits_;
  MemoryBudget bodies_;
  std::atomic<bool> draining_{false};
};

/// Refusals as problems, with the header fields that belong to them.
Problem to_problem(Error error);
Problem to_problem(const Overload& overload);
/// The same as an answer; what is a bug of ours is logged.
Response refusal(Error error, std::string_view request_id);

/// The OpenAPI document as JSON, generated from proto/openapi.yaml at build time.
std::string_view openapi_json();

}  // namespace fracture::http
