#include "server/http/problem.hpp"

#include <array>

#include "common/base/json_text.hpp"

namespace fracture::http {
namespace {

// In the order of problems.def: the error codes of the libraries first, then the HTTP problems.
const std::array kTable = {
#define FRACTURE_STATUS(code, status, advice) \
  ProblemType{slug(ErrorCode::code), title(ErrorCode::code), status, advice},
#define FRACTURE_HTTP_PROBLEM(name, slug, title, status, advice) ProblemType{slug, title, status, advice},
#include "server/http/problems.def"
#undef FRACTURE_STATUS
#undef FRACTURE_HTTP_PROBLEM
};

enum class Row {
#define FRACTURE_STATUS(code, status, advice) code,
#define FRACTURE_HTTP_PROBLEM(name, slug, title, status, advice) name,
#include "server/http/problems.def"
#undef FRACTURE_STATUS
#undef FRACTURE_HTTP_PROBLEM
};

constexpr std::string_view kAcceptPost =
    "model/gltf-binary, model/gltf+json, model/obj, model/stl, application/octet-stream, multipart/form-data";

const ProblemType& at(Row row) { return kTable[static_cast<std::size_t>(row)]; }

}  // namespace

const ProblemType& problem_type(ErrorCode code) {
  // There is no default case, so that the compiler warns if a code in error_codes.def has no status.
  switch (code) {
#define FRACTURE_STATUS(name, status, advice) \
  case ErrorCode::name:                       \
    return at(Row::name);
#define FRACTURE_HTTP_PROBLEM(name, slug, title, status, advice)
#include "server/http/problems.def"
#undef FRACTURE_STATUS
#undef FRACTURE_HTTP_PROBLEM
#define FRACTURE_ERROR(name, slug, title)
#define FRACTURE_LOCAL_ERROR(name, slug, title) case ErrorCode::name:
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
    break;  // client-side errors: a bug if they occur here
  }
  return at(Row::kInternal);
}

const ProblemType& problem_type(HttpProblem problem) {
  switch (problem) {
#define FRACTURE_STATUS(name, status, advice)
#define FRACTURE_HTTP_PROBLEM(name, slug, title, status, advice) \
  case HttpProblem::name:                                        \
    return at(Row::name);
#include "server/http/problems.def"
#undef FRACTURE_STATUS
#undef FRACTURE_HTTP_PROBLEM
  }
  return at(Row::kInternal);
}

std::span<const ProblemType> problem_types() { return kTable; }

Problem to_problem(Error error) {
  Problem problem(error.code, std::move(error.detail));
  problem.pointer = std::move(error.pointer);
  problem.extra = *error.extra;
  if (error.code == ErrorCode::kUnknownFormat) problem.headers.emplace_back("Accept-Post", kAcceptPost);
  if (error.code == ErrorCode::kCancelled) problem.headers.emplace_back("Retry-After", "5");
  if (error.code == ErrorCode::kOutOfMemory) problem.headers.emplace_back("Retry-After", "10");
  if (error.code == ErrorCode::kOverloaded) problem.detail += " Try again after Retry-After.";
  if (error.retry_after.count() > 0)
    problem.headers.emplace_back("Retry-After", std::to_string(error.retry_after.count()));
  if (error.code == ErrorCode::kInternal)
    problem.detail = "This is a bug in the server, not in the request. Please report it with the request_id.";
  return problem;
}

nlohmann::ordered_json Problem::document(std::string_view request_id) const {
  nlohmann::ordered_json document;
  document["type"] = "/problems/" + std::string(type->slug);
  document["title"] = type->title;
  document["status"] = type->status;
  document["detail"] = detail;
  if (!pointer.empty()) document["parameter"] = pointer;
  document["request_id"] = request_id;
  for (const auto& [name, value] : extra.items())
    if (!document.contains(name)) document[name] = nlohmann::ordered_json(value);
  return document;
}

std::string Problem::body(std::string_view request_id) const {
  // Details may quote input of the client, so invalid UTF-8 is replaced instead of throwing an exception.
  return json_text(document(request_id), 2) + "\n";
}

}  // namespace fracture::http
