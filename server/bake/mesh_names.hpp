// Reads the names of a file's nodes and materials from its text, without importing the mesh.
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "common/base/error.hpp"
#include "common/import/formats.hpp"

namespace fracture::bake {

struct MeshNames {
  std::set<std::string> nodes{};      ///< glTF: of nodes and of meshes; OBJ: of objects (o) and groups (g)
  std::set<std::string> materials{};  ///< glTF: all material names; OBJ: those that faces use (usemtl)
};

/// Limits, because the bake process stores these names outside the import sandbox and its --memory limit.
constexpr std::size_t kMaxMeshNames = 200'000;
constexpr std::size_t kMaxMeshNameBytes = 16u << 20;  ///< total size of all names

/// Returns the node and material names in a GLB, glTF or OBJ file. The format is `given`, else it follows
/// from the extension of `path`, else from the first bytes, as for the mesh itself. Unnamed items are left
/// out; the result is empty for other formats and for files that cannot be parsed. In an OBJ, everything
/// after the keyword is one name (`g lid body`), as in its importer, and a backslash at the end of a line
/// joins it with the next. Returns kTooLarge beyond the limits.
Expected<MeshNames> names_in(const std::string& path, std::span<const std::byte> bytes,
                             std::optional<MeshFormat> given = std::nullopt);

}  // namespace fracture::bake
