// Meshes as the store keeps them, made from only a digest and a number of bytes.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "server/service/mesh_store.hpp"

namespace fracture::test {

inline std::shared_ptr<const StoredMesh> stored_mesh(const std::string& digest, std::size_t bytes,
                                                     char fill = 'x') {
  const auto text = std::make_shared<const std::string>(bytes, fill);
  auto stored = std::make_shared<StoredMesh>();
  stored->digest = digest;
  stored->owner = text;
  stored->mesh = std::as_bytes(std::span(text->data(), text->size()));
  return stored;
}

}  // namespace fracture::test
