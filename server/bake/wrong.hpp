// The refusal of what whoever bakes has to correct.
#pragma once

#include <string>
#include <utility>

#include "common/base/error.hpp"

namespace fracture::bake {

/// kBadParameter.
inline tl::unexpected<Error> wrong(std::string detail) {
  return fail(ErrorCode::kBadParameter, std::move(detail));
}

}  // namespace fracture::bake
