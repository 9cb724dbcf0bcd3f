#include "server/bake/failure.hpp"

#include <optional>

namespace fracture::bake {
namespace {

std::string slug_in(const nlohmann::json& problem) {
  const std::string type = problem.value("type", "");
  return type.substr(type.rfind('/') + 1);
}

/// Returns the line "known: Body, Lid" if the problem lists the names that exist, because its detail refers to this list.
std::string known_in(const nlohmann::json& problem) {
  const auto known = problem.find("known");
  if (known == problem.end() || !known->is_array()) return "";
  std::string line;
  for (const nlohmann::json& name : *known)
    if (name.is_string() && name != "")
      line += (line.empty() ? "\n  known: " : ", ") + name.get<std::string>();
  return line;
}

}  // namespace

Outcome outcome_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kCancelled:
      return Outcome::kCancelled;
    case ErrorCode::kUnavailable:
      return Outcome::kUnavailable;
    case ErrorCode::kUnsound:
      return Outcome::kUnsound;
    case ErrorCode::kInternal:
    case ErrorCode::kJobLost:
    case ErrorCode::kOutOfMemory:
    case ErrorCode::kOverloaded:  // no memory for a reader here; busy servers are retried
    case ErrorCode::kServerFailed:
      return Outcome::kFailed;
    default:
      return Outcome::kRefused;
  }
}

Error to_error(int status, const protocol::ProblemDocument& problem) {
  if (const std::optional<ErrorCode> code = error_code(problem.slug()))
    return {*code, problem.detail, problem.parameter, problem.extra};
  const bool failed = status >= 500 && status != 504;
  Error error{failed ? ErrorCode::kServerFailed : ErrorCode::kRefusedByServer, problem.detail,
              problem.parameter};
  nlohmann::json extra = *problem.extra;
  if (!problem.type.empty()) extra["type"] = problem.type;
  if (!problem.title.empty()) extra["title"] = problem.title;
  error.extra = Figures(std::move(extra));
  return error;
}

nlohmann::json to_problem(const Error& error) {
  nlohmann::json problem{{"detail", error.detail}};
  switch (error.code) {
    case ErrorCode::kUnavailable:      // this error does not come from a server
    case ErrorCode::kRefusedByServer:  // type and title, if any, are in `extra`
    case ErrorCode::kServerFailed:
      break;
    default:
      problem["type"] = std::string("/problems/") + slug(error.code);
      problem["title"] = title(error.code);
  }
  if (!error.pointer.empty()) problem["parameter"] = error.pointer;
  for (const auto& [name, value] : error.extra->items())
    if (name != "status" && name != "request_id" && !problem.contains(name)) problem[name] = value;
  return problem;
}

nlohmann::json certificate_of(const Error& error) {
  return error.code == ErrorCode::kUnsound && !error.extra->empty() ? *error.extra : nlohmann::json();
}

std::string to_line(const Error& error) {
  const std::string name = slug_in(to_problem(error));
  return (name.empty() ? name : name + ": ") + error.detail;
}

std::string to_lines(const Error& error) {
  const nlohmann::json problem = to_problem(error);
  const std::string first = problem.value("title", "");
  if (first.empty()) return to_line(error);
  std::string text = slug_in(problem) + ": " + first + "\n  " + error.detail;
  if (const auto errors = problem.find("errors"); errors != problem.end())
    for (std::size_t k = 1; k < errors->size(); ++k) text += "\n  " + (*errors)[k].value("detail", "");
  return text + known_in(problem);
}

}  // namespace fracture::bake
