// The exception that carries a refusal from the helpers inside an importer to its only public function, which
// returns the contained Error. It never leaves the library.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"

namespace fracture {

struct Refused {
  Error error;
};

[[noreturn]] inline void refuse(ErrorCode code, std::string detail, std::string pointer = {},
                                nlohmann::json extra = nlohmann::json::object()) {
  throw Refused{Error{code, std::move(detail), std::move(pointer), Figures(std::move(extra))}};
}

/// Returns items[index]; refuses an index that does not exist.
template <class T>
const T& at(const std::vector<T>& items, int index, const char* what) {
  if (index < 0 || static_cast<std::size_t>(index) >= items.size())
    refuse(ErrorCode::kMalformedMesh,
           std::string("The ") + what + " " + std::to_string(index) + " does not exist.");
  return items[static_cast<std::size_t>(index)];
}

}  // namespace fracture
