// Materials of formats older than glTF, and their conversion to glTF's: the usual mapping of diffuse colour, opacity,
// shininess and emission to metallic-roughness, with textures for colour, normals and emission.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace fracture {

struct PlainMaterial {
  std::string name;                     ///< as in the file, in any encoding
  std::array<float, 3> color{1, 1, 1};  ///< diffuse
  float opacity = 1;
  std::optional<float> metallic, roughness;
  std::optional<float> shininess;  ///< Blinn-Phong exponent; used if the roughness is not known
  std::array<float, 3> emission{};
  bool two_sided = false;
  /// Names of pictures in order of preference: the first one whose bytes are in the upload is used.
  std::vector<std::string> color_maps, normal_maps, emission_maps;
};

/// Returns the glTF texture of a picture; kNoIndex if there is none (FileTextures).
using FindTexture = std::function<std::uint32_t(const std::string& name)>;

/// Returns the material as glTF JSON.
nlohmann::json to_gltf(const PlainMaterial& material, const FindTexture& find_texture);

}  // namespace fracture
