// Bad input is a value: every stage that can refuse its input returns Expected<T>. Exceptions are for broken
// invariants (InternalError) and out-of-memory, caught once per request and in main. The one table of codes
// is error_codes.def; the HTTP status of each stands in server/ and the same names in proto/openapi.yaml.
// Everything that goes wrong is an Error until it leaves: as a Problem over HTTP (to_problem() of
// server/http/problem.hpp), or as words and an exit code of a program (server/bake/failure.hpp,
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
/// The code that a server means by a slug; nothing for any other text.
std::optional<ErrorCode> error_code(std::string_view slug);
/// One short sentence for people.
const char* title(ErrorCode code);

/// What went wrong (code), where (pointer: a JSON pointer or parameter name, may be empty), and how to mend
/// it (detail: one or two sentences that state the offending value and the limit). `extra` carries figures
/// for programs, e.g. {"open_edges": 42, "sample": [x, y, z]}.
struct Error {
  ErrorCode code;
  std::string detail;
  std::string pointer = {};
  Figures extra = {};
  std::chrono::seconds retry_after{0};  ///< kOverloaded, kOverShare: when there should be room; else 0
};

/// "mesh-not-closed: It is open."
std::string to_string(const Error& error);

template <class T>
using Expected = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string detail, std::string pointer = {}) {
  return tl::unexpected<Error>(Error{code, std::move(detail), std::move(pointer)});
}
/// `extra` is an object.
tl::unexpected<Error> fail(ErrorCode code, std::string detail, std::string pointer, nlohmann::json extra);

/// A broken invariant of our own: a bug, never the user's fault. Names the invariant and the ids involved.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

}  // namespace fracture
