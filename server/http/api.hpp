// What the server answers: the table of routes and their handlers. Knows HTTP's meaning but no sockets: a
// session hands it the header (admit), then the whole request (answer), and writes what comes back.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/execution.hpp"
#include "server/http/limits.hpp"
#include "server/http/problem.hpp"
#include "server/http/request_head.hpp"
#include "server/service/memory_budget.hpp"
#include "server/service/service.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture::http {

enum class Listener { kPublic, kAdmin };

struct Response {
  int status = 200;
  std::string content_type;
  std::vector<std::pair<std::string, std::string>> headers;
  std::shared_ptr<const void> owner;  ///< keeps `body` alive; shared with the cache, never copied
  std::span<const std::uint8_t> body;

  static Response text(int status, std::string content_type, std::string body);
  static Response problem(const Problem& problem, std::string_view request_id);
};

struct Route {
  enum class Runs {
    kInline,  ///< answered on the io thread: must not block or compute
    kOnPool,  ///< a job of the worker pool
  };
  Listener listener;
  std::string_view method;
  std::string_view path;  ///< a last segment in braces matches any one segment
  Runs runs;
  std::string_view summary;
};

/// Every method and path there is. HEAD is answered wherever GET is. proto/openapi.yaml describes exactly
/// these.
std::span<const Route> routes();

/// A request that may go on: which route, and what its header already decided.
struct Admission {
  const Route* route = nullptr;
  bool head_only = false;  ///< HEAD: the answer without its body
  std::uint64_t max_body = 0;
  std::string segment;  ///< what a braced last segment matched
  std::vector<std::pair<std::string, std::string>> query;
  std::size_t representation = 0;  ///< which offered media type was negotiated
};

struct Request {
  RequestHead head;
  Admission admission;
  std::string body;
  MemoryBudget::Reservation reservation;  ///< for the body
  std::string id;                         ///< X-Request-Id
  double queue_milliseconds = 0;          ///< from the whole body being there to the start of the work
};

class Api {
 public:
  Api(FractureService& service, WorkerPool& pool, const HttpLimits& limits)
      : service_(service), pool_(pool), limits_(limits), bodies_(limits.max_bodies) {}

  /// Decides from the header alone, before any of the body is read: 404, 405, 406, 413, 415, bad parameters
  /// in the query, no room in the queue.
  OrProblem<Admission> admit(Listener listener, const RequestHead& head) const;

  /// Never throws; a broken invariant becomes a 500 problem and a log line.
  Response answer(const Request& request, const Execution& execution) noexcept;

  Problem overloaded() const;
  void set_draining() { draining_ = true; }
  bool draining() const { return draining_; }
  Problem no_memory() const;
  MemoryBudget& bodies() { return bodies_; }
  const HttpLimits& limits() const { return limits_; }
  WorkerPool& pool() { return pool_; }

 private:
  OrProblem<Response> dispatch(const Request& request, const Execution& execution);
  OrProblem<Response> post_fracture(const Request& request, const Execution& execution);
  OrProblem<Response> get_fracture(const Request& request);
  std::optional<Problem> refuse_media_type(const RequestHead& head, const Admission& admission) const;

  FractureService& service_;
  WorkerPool& pool_;
  const HttpLimits limits_;
  MemoryBudget bodies_;
  std::atomic<bool> draining_{false};
};

/// The OpenAPI document as JSON, generated from proto/openapi.yaml at build time.
std::string_view openapi_json();

}  // namespace fracture::http
