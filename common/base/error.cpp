#include "common/base/error.hpp"

#include <nlohmann/json.hpp>

namespace fracture {

const char* slug(ErrorCode code) {
  switch (code) {
#define FRACTURE_ERROR(name, slug, title) \
  case ErrorCode::name:                   \
    return slug;
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
  }
  return "internal";
}

const char* title(ErrorCode code) {
  switch (code) {
#define FRACTURE_ERROR(name, slug, title) \
  case ErrorCode::name:                   \
    return title;
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
  }
  return "An internal invariant was broken";
}

tl::unexpected<Error> fail(ErrorCode code, std::string detail, std::string pointer, nlohmann::json extra) {
  return tl::unexpected<Error>(Error{code, std::move(detail), std::move(pointer), Figures(std::move(extra))});
}

}  // namespace fracture
