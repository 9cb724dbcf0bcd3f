// Why there is no output, which is an Error: what becomes of the job, how the report and the console say it, and how
// the refusal of a server becomes one.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/base/error.hpp"
#include "common/exchange/problem_document.hpp"

namespace fracture::bake {

/// What an error comes to for the one who bakes.
enum class Outcome {
  kRefused,      ///< the mesh or a parameter: it will be refused again
  kFailed,       ///< a bug, here or in the server, or lack of memory
  kUnsound,      ///< a bug too: the answer does not prove itself, and nobody gets it
  kCancelled,    ///< the stop came
  kUnavailable,  ///< the server is absent or busy beyond all patience: the other jobs will fare no better
};
Outcome outcome_of(ErrorCode code);

/// Of an answer that refuses: the code that its type names, with the same words as here. What is no error of the
/// pipeline (a proxy's answer, a limit of HTTP) is kRefusedByServer or, by its status, kServerFailed; type and title
/// are in `extra` where it has any. What else the server says for programs is in `extra` too.
Error to_error(int status, const protocol::ProblemDocument& problem);

/// As a server words it (to_problem() of server/http/problem.hpp): type, title, detail, parameter where one is concerned,
/// and all that the error carries for programs (errors, known, figures); without status and request_id, which belong to
/// an exchange.
nlohmann::json to_problem(const Error& error);
/// Of what is unsound, as far as it is known; else null.
nlohmann::json certificate_of(const Error& error);

/// "mesh-not-closed: It is open."
std::string to_line(const Error& error);
/// The same with the title in a first line and everything else that is wrong in further ones.
std::string to_lines(const Error& error);

}  // namespace fracture::bake
