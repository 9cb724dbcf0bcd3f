#include "common/base/error.hpp"

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

}  // namespace fracture
