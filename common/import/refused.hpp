// Inside an importer a refusal comes out of deep helpers; it travels as this exception to the importer's one
// public function, which turns it into the Error it carries. It never leaves the library.
#pragma once

#include <string>
#include <utility>

#include "common/base/error.hpp"

namespace fracture {

struct Refused {
  Error error;
};

[[noreturn]] inline void refuse(ErrorCode code, std::string detail, std::string pointer = {},
                                nlohmann::json extra = nlohmann::json::object()) {
  throw Refused{Error{code, std::move(detail), std::move(pointer), std::move(extra)}};
}

}  // namespace fracture
