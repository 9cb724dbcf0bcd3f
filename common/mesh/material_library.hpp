// The appearance of a mesh's surfaces. It is separate from mesh.hpp because most code that uses meshes never
// reads it, and the JSON library is slow to compile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fracture {

/// An image as in the source, byte for byte.
struct Image {
  std::string name;
  std::string mime_type;  ///< "image/png", "image/jpeg", "image/webp", "image/ktx2"
  std::vector<std::uint8_t> bytes;
};

/// Maximum memory of the three parsed lists of a MaterialLibrary together (json_bytes). A scene with 10,000
/// materials takes a quarter of it.
inline constexpr std::size_t kMaxLibraryBytes = 32u << 20;

/// Materials in the form of glTF: `materials[k]`, `textures[k]` and `samplers[k]` are glTF 2.0 JSON objects
/// whose indices refer to the arrays here (a texture's "source" is an index into `images`). Importers of
/// other formats convert to this form, so the exporter can write every material back without loss.
struct MaterialLibrary {
  nlohmann::json materials = nlohmann::json::array();
  nlohmann::json textures = nlohmann::json::array();
  nlohmann::json samplers = nlohmann::json::array();
  std::vector<Image> images;
  std::vector<std::string> extensions_used;      ///< material and texture extensions only
  std::vector<std::string> extensions_required;  ///< subset of extensions_used
};

}  // namespace fracture
