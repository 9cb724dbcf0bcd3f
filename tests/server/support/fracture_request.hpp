// A request in the form that the dispatcher takes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "server/service/request.hpp"

namespace fracture::test {

/// The request owns its bytes.
inline FractureRequest fracture_request(const std::string& mesh, std::uint64_t seed = 1) {
  FractureRequest r;
  const auto text = std::make_shared<const std::string>(mesh);
  r.mesh = std::as_bytes(std::span(text->data(), text->size()));
  r.owner = text;
  r.parameters.fracture.seed = seed;
  return r;
}

}  // namespace fracture::test
