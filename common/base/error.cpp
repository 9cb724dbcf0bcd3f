#include "common/base/error.hpp"

#include <nlohmann/json.hpp>

namespace fracture {

const char* slug(ErrorCode code) {
  switch (code) {
#define FRACTURE_ERROR(name, slug, title) \
  case ErrorCode::name:                   \
    return slug;
#define FRACTURE_LOCAL_ERROR FRACTURE_ERROR
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
  }
  return "internal";
}

std::optional<ErrorCode> error_code(std::string_view text) {
#define FRACTURE_ERROR(name, slug, title) \
  if (text == (slug)) return ErrorCode::name;
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
  return std::nullopt;
}

const char* title(ErrorCode code) {
  switch (code) {
#define FRACTURE_ERROR(name, slug, title) \
  case ErrorCode::name:                   \
    return title;
#define FRACTURE_LOCAL_ERROR FRACTURE_ERROR
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
  }
  return "An internal invariant was broken";
}

tl::unexpected<Error> fail(ErrorCode code, std::string detail, std::string pointer, nlohmann::json extra) {
  return tl::unexpected<Error>(Error{code, std::move(detail), std::move(pointer), Figures(std::move(extra))});
}

std::string to_string(const Error& error) { return std::string(slug(error.code)) + ": " + error.detail; }

}  // namespace fracture
