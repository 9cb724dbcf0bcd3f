#include "server/http/api.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <new>

namespace fracture::http {
namespace {

constexpr std::string_view kAcceptPost =
    "model/gltf-binary, model/gltf+json, model/obj, model/stl, application/octet-stream, multipart/form-data";

}  // namespace

std::vector<RawParameter> raw_parameters(const std::vector<std::pair<std::string, std::string>>& query) {
  std::vector<RawParameter> given;
  given.reserve(query.size());
  for (const auto& [name, value] : query) given.push_back({name, value, true});
  return given;
}

Problem to_problem(Error error) {
  const ErrorCode code = error.code;
  Problem problem(std::move(error));
  if (code == ErrorCode::kUnknownFormat) problem.headers.emplace_back("Accept-Post", kAcceptPost);
  if (code == ErrorCode::kCancelled) problem.headers.emplace_back("Retry-After", "5");
  return problem;
}

Problem unknown_format(const FormatSet& formats, std::string_view given) {
  std::string names;
  for (const std::string& name : formats.names()) names += (names.empty() ? "" : ", ") + name;
  std::string detail = "The request does not say what format the mesh has.";
  if (!given.empty())
    detail = std::string(given).insert(0, 1, '\'') + "' names no mesh format that this server reads.";
  return to_problem(
      {ErrorCode::kUnknownFormat,
       detail + " Say it in Content-Type (for example model/gltf-binary) or as ?format= with one of " +
           names + ".",
       "format"});
}

void Api::start(std::shared_ptr<Request> request, std::stop_token gone, std::function<void(Response)> reply) {
  if (request->admission.route->runs == Route::Runs::kInline) {
    reply(answer(*request, Execution{}));
    return;
  }
  const auto received = std::chrono::steady_clock::now();
  auto job = [this, request, received, gone = std::move(gone), reply](int threads) {
    const auto begin = std::chrono::steady_clock::now();
    request->queue_milliseconds = std::chrono::duration<double, std::milli>(begin - received).count();
    Execution execution;
    execution.threads = threads;
    execution.stop = gone;
    execution.deadline = received + limits_.deadline;
    Response response = answer(*request, execution);
    // The mesh is not needed while the answer is written.
    std::string().swap(request->body);
    request->reservation = {};
    reply(std::move(response));
  };
  if (!pool_.try_submit(std::move(job))) reply(Response::problem(overloaded(), request->id));
}

Response Api::answer(const Request& request, const Execution& execution) noexcept {
  try {
    OrProblem<Response> response = dispatch(request, execution);
    if (response) return std::move(*response);
    return Response::problem(response.error(), request.id);
  } catch (const std::bad_alloc&) {
    spdlog::error("{} out of memory", request.id);
    return Response::problem(
        Problem(HttpProblem::kOverloaded, "There is not enough memory for this request now.")
            .with("Retry-After", "10"),
        request.id);
  } catch (const std::exception& e) {
    spdlog::error("{} broken invariant: {}", request.id, e.what());
  } catch (...) {
    spdlog::error("{} an exception of unknown type", request.id);
  }
  return Response::problem(Problem(Error{ErrorCode::kInternal,
                                         "This is a bug of the server, not of the request. Please report it "
                                         "with the request_id."}),
                           request.id);
}

OrProblem<Response> Api::dispatch(const Request& request, const Execution& execution) {
  switch (request.admission.route->operation) {
    case Operation::kGetIndex:
      return get_index();
    case Operation::kGetVersion:
      return get_version();
    case Operation::kGetLimits:
      return get_limits();
    case Operation::kGetOpenapi:
      return get_openapi();
    case Operation::kPostFracture:
      return post_fracture(request, execution);
    case Operation::kGetFracture:
      return get_fracture(request);
    case Operation::kGetLivez:
      return Response::text(200, "text/plain", "alive\n");
    case Operation::kGetReadyz:
      return get_readyz();
  }
  throw InternalError("a route without a handler");
}

}  // namespace fracture::http
