// The appearance of a mesh's surfaces. It is separate from mesh.hpp because most code that uses meshes never
// reads it, and the JSON library is slow to compile.
#pragma once

#include <array>
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
  nlohmann::json variants =
      nlohmann::json::array();  ///< the source's KHR_materials_variants.variants; objects
  /// For each material: the KHR_materials_variants of primitives with this material ({"mappings": [...]}), or {}. Empty: no
  /// primitive has any. A source's material that several primitives map differently is in `materials` several times.
  nlohmann::json variant_mappings = nlohmann::json::array();
  std::vector<std::string> extensions_used;      ///< material and texture extensions only
  std::vector<std::string> extensions_required;  ///< subset of extensions_used
};

/// The lists of JSON objects of a library.
template <class Library>
auto json_lists(Library& library) {
  return std::array{&library.materials, &library.textures, &library.samplers, &library.variants,
                    &library.variant_mappings};
}

/// Returns the indices of the material, and of those that a variant has in its place.
std::vector<std::size_t> looks_of(const MaterialLibrary& library, std::size_t material);

/// Whether the material (or one of its extensions) has a normal map. Only such materials need tangents. Calls step() for each
/// object.
template <class Step>
bool has_normal_map(const nlohmann::json& material, const Step& step) {
  if (!material.is_object()) return false;
  step();
  for (const auto& [key, child] : material.items()) {
    if (key == "extras") continue;
    if (key == "normalTexture" || key == "clearcoatNormalTexture" || has_normal_map(child, step)) return true;
  }
  return false;
}

/// Whether `variant_mappings` fits the materials and the variants.
bool has_sound_variants(const MaterialLibrary& library);

}  // namespace fracture
