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

#include "common/base/execution.hpp"
#include "server/http/limits.hpp"
#include "server/http/message.hpp"
#include "server/http/routes.hpp"
#include "server/service/memory_budget.hpp"
#include "server/service/service.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture::http {

class Api {
 public:
  Api(FractureService& service, WorkerPool& pool, const HttpLimits& limits)
      : service_(service), pool_(pool), limits_(limits), bodies_(limits.max_bodies) {}

  /// Decides from the header alone, before any of the body is read: 404, 405, 406, 413, 415, bad parameters
  /// in the query, no room in the queue.
  OrProblem<Admission> admit(Listener listener, const RequestHead& head) const;

  /// Answers through `reply`, which is called exactly once: before this returns or later, from any thread. A
  /// stop of `gone` says that nobody waits for the answer any more. A broken invariant becomes a 500 problem
  /// and a log line.
  void start(std::shared_ptr<Request> request, std::stop_token gone, std::function<void(Response)> reply);
  /// Returns when nothing is computed any more and no reply is outstanding.
  void wait_idle() { pool_.wait_idle(); }

  void set_draining() { draining_ = true; }
  bool draining() const { return draining_; }
  Problem no_memory() const;
  MemoryBudget& bodies() { return bodies_; }
  const HttpLimits& limits() const { return limits_; }

 private:
  Response answer(const Request& request, const Execution& execution) noexcept;
  Problem overloaded() const;
  OrProblem<Response> dispatch(const Request& request, const Execution& execution);
  OrProblem<Response> post_fracture(const Request& request, const Execution& execution);
  OrProblem<Response> get_fracture(const Request& request);
  Response get_index() const;
  Response get_version() const;
  Response get_limits() const;
  Response get_openapi() const;
  OrProblem<Response> get_readyz() const;
  std::optional<Problem> refuse_media_type(const RequestHead& head, const Admission& admission) const;

  FractureService& service_;
  WorkerPool& pool_;
  const HttpLimits limits_;
  MemoryBudget bodies_;
  std::atomic<bool> draining_{false};
};

/// Refusal of the library as a problem, with the header fields that belong to it.
Problem to_problem(Error error);
/// 415 with the list of what is read; `given` is what the client said, may be empty.
Problem unknown_format(const FormatSet& formats, std::string_view given);
/// The query as the parameter table wants it.
std::vector<RawParameter> raw_parameters(const std::vector<std::pair<std::string, std::string>>& query);

/// The OpenAPI document as JSON, generated from proto/openapi.yaml at build time.
std::string_view openapi_json();

}  // namespace fracture::http
