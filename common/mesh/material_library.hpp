// What the surfaces of a mesh look like. Apart from mesh.hpp, because most of who works on meshes never reads it, and the JSON
// library takes longer to compile than they do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fracture {

/// An image as the source holds it, byte for byte.
struct Image {
  std::string name;
  std::string mime_type;  ///< "image/png", "image/jpeg", "image/webp", "image/ktx2"
  std::vector<std::uint8_t> bytes;
};

/// Most that the three lists of a MaterialLibrary may hold together when they are parsed (json_bytes). A
/// scene of 10,000 materials takes a quarter of it.
inline constexpr std::size_t kMaxLibraryBytes = 32u << 20;

/// Materials in glTF's own terms: `materials[k]`, `textures[k]`, `samplers[k]` are glTF 2.0 JSON objects
/// whose indices refer to the arrays here (a texture's "source" is an index into `images`). Importers of
/// other formats translate into these terms, so that the exporter writes every material back with what it
/// had.
struct MaterialLibrary {
  nlohmann::json materials = nlohmann::json::array();
  nlohmann::json textures = nlohmann::json::array();
  nlohmann::json samplers = nlohmann::json::array();
  std::vector<Image> images;
  std::vector<std::string> extensions_used;      ///< material and texture extensions only
  std::vector<std::string> extensions_required;  ///< subset of extensions_used
};

}  // namespace fracture
