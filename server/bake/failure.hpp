// Errors of a bake: how an error decides the outcome of a job, how the report and the console word it, and
// how a server's refusal is converted to an Error.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/base/error.hpp"
#include "common/exchange/problem_document.hpp"

namespace fracture::bake {

/// The outcome of a failed job, as the user of a bake sees it.
enum class Outcome {
  kRefused,      ///< because of the mesh or a parameter: a new attempt would be refused too
  kFailed,       ///< a bug here or in the server, or not enough memory
  kUnsound,      ///< a bug as well: the answer fails its own checks and is not written
  kCancelled,    ///< a stop was requested
  kUnavailable,  ///< the server is absent, or busy for too long: the other jobs would fail too
};
Outcome outcome_of(ErrorCode code);

/// Converts a server's refusal to an Error. If the problem's type is one of ours, the Error has that type's
/// code and the server's words. Any other problem (a proxy's answer, an HTTP limit) becomes kServerFailed or
/// kRefusedByServer, depending on its status; its type and title, if any, are stored in `extra`. All other
/// machine-readable members are stored in `extra` too.
Error to_error(int status, const protocol::ProblemDocument& problem);

/// Converts an error to a problem document like that of a server (to_problem() in server/http/problem.hpp).
/// It contains type, title, detail, the parameter if one is concerned, and all machine-readable members
/// (errors, known, figures). It does not contain status and request_id, which belong to an HTTP exchange.
nlohmann::json to_problem(const Error& error);
/// Returns the certificate in a kUnsound error, or null if there is none.
nlohmann::json certificate_of(const Error& error);

/// Returns one line: "mesh-not-closed: It is open."
std::string to_line(const Error& error);
/// Returns several lines: the title, the detail, then the details of any further errors.
std::string to_lines(const Error& error);

}  // namespace fracture::bake
