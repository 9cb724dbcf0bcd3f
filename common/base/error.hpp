// Bad input is a value: every stage that can refuse its input returns Expected<T>. Exceptions are only for
// broken invariants (InternalError) and lack of memory, and are caught once per request and in main. The
// single table of codes is error_codes.def; server/ assigns their HTTP status, and proto/openapi.yaml uses
// the same names. Every failure is an Error until it leaves the program: as a Problem over HTTP (to_problem()
// in server/http/problem.hpp), or as a message and an exit code (server/bake/failure.hpp,
// server/cli/exit_codes.hpp).
#pragma once

#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "common/base/figures.hpp"

namespace fracture {

enum class ErrorCode {
#define FRACTURE_ERROR(name, slug, title) name,
#define FRACTURE_LOCAL_ERROR FRACTURE_ERROR
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
};

/// The stable name of a code, e.g. "mesh-not-closed": the last path segment of the problem type.
const char* slug(ErrorCode code);
/// The code for a slug that a server sent; none for any other text.
std::optional<ErrorCode> error_code(std::string_view slug);
/// One short sentence for people.
const char* title(ErrorCode code);

/// A failure: its kind (code), its place (pointer: a JSON pointer or parameter name, may be empty), and how to fix it
/// (detail: one or two sentences that state the offending value and the limit). `extra` has data for
/// programs, e.g. {"open_edges": 42, "sample": [x, y, z]}.
struct Error {
  ErrorCode code;
  std::string detail;
  std::string pointer = {};
  Figures extra = {};
  std::chrono::seconds retry_after{0};  ///< kOverloaded, kOverShare: when to try again; otherwise 0
};

/// Formats an error, e.g. "mesh-not-closed: It is open."
std::string to_string(const Error& error);

template <class T>
using Expected = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string detail, std::string pointer = {}) {
  return tl::unexpected<Error>(Error{code, std::move(detail), std::move(pointer)});
}
/// `extra` must be a JSON object.
tl::unexpected<Error> fail(ErrorCode code, std::string detail, std::string pointer, nlohmann::json extra);

/// A broken invariant: a bug in this project, never the user's fault. The message names the invariant and the
/// ids involved.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

}  // namespace fracture
