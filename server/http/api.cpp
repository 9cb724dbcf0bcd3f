#include "server/http/api.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <new>

#include "common/base/words.hpp"
#include "server/http/auth.hpp"

namespace fracture::http {
namespace {

/// Returns one client's share of the memory for small bodies: the same fraction as for large bodies.
std::uint64_t small_share(const HttpLimits& limits) {
  const double fraction = static_cast<double>(limits.body_share()) /
                          static_cast<double>(std::max<std::uint64_t>(1, limits.max_bodies));
  return static_cast<std::uint64_t>(fraction * static_cast<double>(limits.max_small_bodies));
}

}  // namespace

Response refusal(Error error, std::string_view request_id) {
  if (error.code == ErrorCode::kInternal) spdlog::error("{} broken invariant: {}", request_id, error.detail);
  if (error.code == ErrorCode::kUnsound) spdlog::error("{} unsound answer: {}", request_id, error.detail);
  if (error.code == ErrorCode::kOutOfMemory) spdlog::error("{} out of memory: {}", request_id, error.detail);
  return Response::problem(to_problem(std::move(error)), request_id);
}

Api::Api(Dispatcher& dispatcher, const HttpLimits& limits, const StoreConfig& store, const JobsConfig& jobs)
    : dispatcher_(dispatcher),
      service_(dispatcher.service()),
      limits_(limits),
      bodies_(limits.max_bodies, limits.body_share(), {limits.max_small_bodies, kSmallBody},
              small_share(limits)),
      answers_(limits.max_answers, limits.answer_share(),
               [this](const std::string& address, std::uint64_t bytes,
                      std::shared_ptr<const void>& aside) -> std::optional<HeldBuffers::Refusal> {
                 const auto verdict = dispatcher_.set_aside("address " + address, bytes, aside);
                 if (verdict == MemoryBudget::Verdict::kFits) return std::nullopt;
                 return verdict == MemoryBudget::Verdict::kOverShare ? HeldBuffers::Refusal::kOverShare
                                                                     : HeldBuffers::Refusal::kFull;
               }),
      meshes_(store),
      held_meshes_(store.quota_bytes, store.quota_bytes / 2),
      ledger_(limits.answer_ledger),
      jobs_(dispatcher, jobs),
      compressions_(dispatcher) {
  limits_text_ = describe_limits().dump(2) + "\n";
  patterns_text_ = service_.parameters().patterns_to_json().dump(2) + "\n";
  metrics_.add_source([this](ops::MetricWriter& writer) { write_metrics(writer); });
  sweep_later();
}

Api::~Api() { wait_idle(); }

void Api::wait_idle() {
  jobs_.stop();
  jobs_.flush();  // no job is resumed after this
  dispatcher_.wait_idle();
  jobs_.flush();  // writes the results of the work that just ended
  // Only watchers of finished jobs and keep-alive timers remain.
  jobs_.drop_watchers();
  closing_ = true;  // a running sweep does not schedule another one
  dispatcher_.timer().flush();
  dispatcher_.timer().clear();
}

std::optional<Problem> Api::hold_answer(const std::string& address, const void* owner, std::uint64_t bytes,
                                        HeldBuffers::Hold& hold) {
  if (bytes <= kSmallAnswer) return std::nullopt;
  const auto refusal = answers_.take(address, owner, bytes, hold);
  if (!refusal) return std::nullopt;
  const bool share = *refusal == HeldBuffers::Refusal::kOverShare;
  return Problem(
             share ? ErrorCode::kOverShare : ErrorCode::kOverloaded,
             share
                 ? "This client's unread answers and other requests use up its share of the memory. Read the "
                   "answers first."
                 : "Unread answers and computations leave too little memory for this answer of " +
                       data_size(bytes) + " (--max-answers, --max-working). Try again after Retry-After.")
      .with("Retry-After", "2");
}

Expected<bool> Api::take_folder() {
  const Expected<bool> tier = service_.tiers().take_folder();
  return tier && *tier ? jobs_.take_folder() : tier;
}

void Api::sweep_later() {
  constexpr std::chrono::seconds kInterval{10};
  if (closing_) return;
  dispatcher_.timer().at(Timer::Clock::now() + kInterval, [this] {
    // An exception ends only this sweep, so the next one is scheduled first. If scheduling fails for lack of
    // memory, it is tried again below.
    bool later = false;
    try {
      sweep_later();
      later = true;
      meshes_.sweep();
      jobs_.sweep();
    } catch (const std::exception& e) {
      spdlog::warn("deleting expired meshes and jobs failed: {}", e.what());
    }
    if (!later) sweep_later();
  });
}

void Api::answering(const Request& request, const Reply& reply,
                    const std::function<Answered()>& handle) noexcept {
  Error error{ErrorCode::kInternal, "an exception of unknown type"};
  try {
    Answered response = handle();
    if (!response)
      reply(Response::problem(response.error(), request.id));
    else if (*response)
      reply(std::move(**response));
    return;
  } catch (const Interrupted& interrupted) {
    error = to_error(interrupted);
  } catch (const std::bad_alloc&) {
    error = {ErrorCode::kOutOfMemory,
             "The server does not have enough memory for this request at the moment."};
  } catch (const std::exception& e) {
    error.detail = e.what();
  } catch (...) {
  }
  try {
    reply(refusal(with_time(std::move(error), request), request.id));
  } catch (...) {  // only this client is left without an answer
  }
}

Answered Api::dispatch(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                       const Reply& reply) {
  switch (request->admission.route->operation) {
    case Operation::kGetIndex:
      if (page_ && request->admission.representation == kIndexAsHtml) return get_page(*request, "index.html");
      return get_index();
    case Operation::kGetDocs:
      return get_page(*request, "docs.html");
    case Operation::kGetPageFile:
      return get_page(*request, request->admission.segment);
    case Operation::kGetVersion:
      return get_version();
    case Operation::kGetLimits:
      return get_limits();
    case Operation::kGetPatterns:
      return get_patterns();
    case Operation::kGetOpenapi:
      return get_openapi();
    case Operation::kGetLlms:
      return get_llms();
    case Operation::kGetProblem:
      return get_problem(*request);
    case Operation::kPostFracture:
      return post_fracture(request, gone, reply);
    case Operation::kGetFracture:
      return get_fracture(request, gone, reply);
    case Operation::kPutMesh:
    case Operation::kPostMesh:
      return put_mesh(request, gone, reply);
    case Operation::kGetMesh:
      return get_mesh(*request);
    case Operation::kDeleteMesh:
      return delete_mesh(*request);
    case Operation::kPostMeshFracture:
    case Operation::kPostMeshEstimate:
      return fracture_stored(request, request->body, request->admission.segment, gone, reply);
    case Operation::kGetJob:
      return get_job(request, gone, reply);
    case Operation::kGetJobs:
      return get_jobs(request, gone, reply);
    case Operation::kDeleteJob:
      return delete_job(*request);
    case Operation::kGetJobEvents:
      return get_job_events(*request);
    case Operation::kGetLivez:
      return Response::text(200, "text/plain", "alive\n");
    case Operation::kGetReadyz:
      return get_readyz();
    case Operation::kGetMetrics:
      return Response::text(200, ops::Metrics::kContentType, metrics_.text());
  }
  throw InternalError("a route without a handler");
}

}  // namespace fracture::http
