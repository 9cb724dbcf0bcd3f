// What a mesh file calls its nodes and materials, read from its text alone: nothing is imported for it.
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
  std::set<std::string> materials{};  ///< glTF: of materials; OBJ: those that faces use (usemtl)
};

/// Names are kept by the process that bakes, which no sandbox and no --memory holds.
constexpr std::size_t kMaxMeshNames = 200'000;
constexpr std::size_t kMaxMeshNameBytes = 16u << 20;  ///< of all of them together

/// Of GLB, glTF and OBJ, which `given`, else the ending of `path`, else the first bytes tell, as for the mesh itself; empty
/// for other formats and for what cannot be parsed. What has no name is not in it. In an OBJ all of a line is one name (`g lid
/// body`), as its importer has it, and a backslash at its end joins it with the next. kTooLarge: over the limits.
Expected<MeshNames> names_in(const std::string& path, std::span<const std::byte> bytes,
                             std::optional<MeshFormat> given = std::nullopt);

}  // namespace fracture::bake
