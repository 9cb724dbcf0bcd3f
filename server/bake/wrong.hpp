// The error for a mistake that the user must correct.
#pragma once

#include <string>
#include <utility>

#include "common/base/error.hpp"

namespace fracture::bake {

/// Returns kBadParameter.
inline tl::unexpected<Error> wrong(std::string detail) {
  return fail(ErrorCode::kBadParameter, std::move(detail));
}

}  // namespace fracture::bake
