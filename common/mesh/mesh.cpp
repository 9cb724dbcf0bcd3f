#include "common/mesh/mesh.hpp"

#include "common/mesh/material_library.hpp"

namespace fracture {

std::shared_ptr<const MaterialLibrary> empty_library() {
  static const auto empty = std::make_shared<const MaterialLibrary>();
  return empty;
}

}  // namespace fracture
