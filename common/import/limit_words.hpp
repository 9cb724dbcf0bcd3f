// Words for errors about import limits: each names the limit, the setting of a server that raises it, and what to do.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/words.hpp"
#include "common/import/import_input.hpp"

namespace fracture {

/// The advice of every error about the size of a mesh.
inline constexpr const char* kSmallerMesh = "Reduce the mesh, or divide it into several files.";

/// Returns "4,000,000 triangles (server option --max-triangles)".
inline std::string triangle_limit(std::uint64_t most) {
  return counted(most, "triangle", "triangles") + " (server option --max-triangles)";
}

/// Returns "268.4 MB (server option --max-decoded)".
inline std::string decoded_limit(std::uint64_t most) {
  return data_size(most) + " (server option --max-decoded)";
}

}  // namespace fracture
