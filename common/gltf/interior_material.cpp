#include "common/gltf/interior_material.hpp"

#include <charconv>
#include <cmath>

namespace fracture {
namespace {

const char* const kDefaultName = "Interior";

/// A name stands for the first material that is called so; what is no name but a number is an index.
const nlohmann::json* find_material(const std::string& wanted, const nlohmann::json& materials) {
  for (const auto& material : materials)
    if (material.value("name", "") == wanted) return &material;
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
  const bool number = error == std::errc{} && end == wanted.data() + wanted.size();
  return number && index < materials.size() ? &materials[index] : nullptr;
}

}  // namespace

nlohmann::json plain_interior_material() {
  return {{"name", kDefaultName},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {0.55, 0.5, 0.45, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.9}}}};
}

Expected<nlohmann::json> interior_material(const InteriorLook& look, const MaterialLibrary& library) {
  nlohmann::json material = plain_interior_material();
  if (!look.material.empty()) {
    const nlohmann::json* source = find_material(look.material, library.materials);
    if (source == nullptr) {
      nlohmann::json known = nlohmann::json::array();
      for (const auto& m : library.materials) known.push_back(m.value("name", ""));
      const std::size_t count = known.size();
      return fail(ErrorCode::kBadParameter,
                  "'interior_material': the mesh has no material '" + look.material + "'; it has " +
                      std::to_string(count) + ".",
                  "interior_material", {{"known", std::move(known)}});
    }
    material = *source;
    const std::string name = material.value("name", "");
    material["name"] = name.empty() ? std::string(kDefaultName) : std::string(kDefaultName) + "_" + name;
  }
  if (look.name) material["name"] = *look.name;
  if (!look.color && !look.roughness && !look.metallic) return material;
  nlohmann::json& pbr = material["pbrMetallicRoughness"];
  if (look.color) {
    pbr["baseColorFactor"] = {look.color->x, look.color->y, look.color->z, 1};
    pbr.erase("baseColorTexture");
  }
  if (look.roughness) pbr["roughnessFactor"] = *look.roughness;
  if (look.metallic) pbr["metallicFactor"] = *look.metallic;
  return material;
}

std::optional<Vec3d> linear_color(std::string_view hex) {
  if (hex.size() != 7 || hex[0] != '#') return std::nullopt;
  Vec3d color;
  for (int k = 0; k < 3; ++k) {
    unsigned byte = 0;
    const char* begin = hex.data() + 1 + 2 * k;
    const auto [end, error] = std::from_chars(begin, begin + 2, byte, 16);
    if (error != std::errc{} || end != begin + 2) return std::nullopt;
    const double s = byte / 255.0;
    // Rounded to six digits: the last bits of pow() differ between C libraries.
    const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    color[k] = std::nearbyint(linear * 1e6) / 1e6;
  }
  return color;
}

}  // namespace fracture
