// Every error that a client can see, as problem details (RFC 9457). The only table (problems.def) maps the
// libraries' error codes to statuses and adds the refusals of HTTP itself. proto/openapi.yaml lists the same
// slugs, and a test compares them.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "common/base/error.hpp"

namespace fracture::http {

enum class HttpProblem {
#define FRACTURE_STATUS(code, status, advice)
#define FRACTURE_HTTP_PROBLEM(name, slug, title, status, advice) name,
#include "server/http/problems.def"
#undef FRACTURE_STATUS
#undef FRACTURE_HTTP_PROBLEM
};

struct ProblemType {
  std::string_view slug;
  std::string_view title;
  int status;
  std::string_view advice;  ///< meaning and remedy, for people
};

const ProblemType& problem_type(ErrorCode code);
const ProblemType& problem_type(HttpProblem problem);
/// Returns the whole table.
std::span<const ProblemType> problem_types();

/// A refusal: its type, what is wrong with this request, and the header fields to send with it (Allow,
/// Retry-After, …).
struct Problem {
  const ProblemType* type;
  std::string detail;
  std::string pointer{};  ///< the parameter, part or header field concerned; may be empty
  nlohmann::json extra = nlohmann::json::object();
  std::vector<std::pair<std::string, std::string>> headers{};

  Problem(HttpProblem problem, std::string problem_detail)
      : type(&problem_type(problem)), detail(std::move(problem_detail)) {}
  Problem(ErrorCode code, std::string problem_detail)
      : type(&problem_type(code)), detail(std::move(problem_detail)) {}

  Problem&& with(std::string name, std::string value) && {
    headers.emplace_back(std::move(name), std::move(value));
    return std::move(*this);
  }

  /// Returns the members type (/problems/<slug>), title, status, detail, request_id, parameter, and `extra`.
  nlohmann::ordered_json document(std::string_view request_id) const;
  /// Returns document() as an application/problem+json body.
  std::string body(std::string_view request_id) const;
};

/// Converts an error to a problem, with the header fields to send with it.
Problem to_problem(Error error);

template <class T>
using OrProblem = tl::expected<T, Problem>;

inline tl::unexpected<Problem> refuse(HttpProblem problem, std::string detail) {
  return tl::unexpected<Problem>(Problem(problem, std::move(detail)));
}

}  // namespace fracture::http
