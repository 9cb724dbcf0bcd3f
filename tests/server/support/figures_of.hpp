// The report inside an answer's file.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "server/service/result.hpp"

namespace fracture::test {

/// The extras.fracture object of the root node, read at the position that the result states.
inline nlohmann::json figures_of(const FractureResult& result) {
  const std::span<const std::uint8_t> text = result.bytes_of(result.figures);
  return nlohmann::json::parse(text.begin(), text.end());
}

}  // namespace fracture::test
