#include "common/outputs/answer_document.hpp"

namespace fracture::outputs {
namespace {

using nlohmann::json;

/// In glTF, members with default values are absent.
const json& member(const json& object, const char* key) {
  static const json kAbsent = json::object();
  const auto at = object.find(key);
  return at == object.end() ? kAbsent : *at;
}

Vec3d color_at(const json& object, const char* key, Vec3d fallback) {
  const auto at = object.find(key);
  if (at == object.end()) return fallback;
  return {at->at(0).get<double>(), at->at(1).get<double>(), at->at(2).get<double>()};
}

/// The image of a texture. Extensions may give it for formats that core glTF does not support
/// (EXT_texture_webp, KHR_texture_basisu).
std::optional<std::size_t> image_of(const json& texture) {
  if (texture.contains("source")) return number_at(texture, "source", 0);
  for (const auto& [name, extension] : member(texture, "extensions").items())
    if (extension.is_object() && extension.contains("source")) return number_at(extension, "source", 0);
  return std::nullopt;
}

std::optional<Map> map_at(const json& document, const json& object, const char* key, std::size_t images) {
  const auto info = object.find(key);
  if (info == object.end()) return std::nullopt;
  const std::optional<std::size_t> image =
      image_of(element(document, "textures", number_at(*info, "index", kHasToBeThere)));
  if (!image) return std::nullopt;
  if (*image >= images) throw Broken{"a texture names image " + std::to_string(*image)};
  Map map{.image = *image, .uv_set = number_at(*info, "texCoord", 0)};
  const json& transform = member(member(*info, "extensions"), "KHR_texture_transform");
  map.uv_set = number_at(transform, "texCoord", map.uv_set);
  for (std::size_t k = 0; k < 2; ++k) {
    if (transform.contains("scale")) map.scale[k] = transform.at("scale").at(k).get<double>();
    if (transform.contains("offset")) map.offset[k] = transform.at("offset").at(k).get<double>();
  }
  return map;
}

}  // namespace

std::vector<Material> read_materials(const json& document, std::size_t images) {
  std::vector<Material> materials;
  Names names;
  names.add(kBareMaterial);
  for (const json& source : member(document, "materials")) {
    const json& pbr = member(source, "pbrMetallicRoughness");
    Material material;
    material.name = names.add(source.value("name", "material_" + std::to_string(materials.size())));
    material.color = color_at(pbr, "baseColorFactor", {1, 1, 1});
    if (source.value("alphaMode", "OPAQUE") != "OPAQUE" && pbr.contains("baseColorFactor"))
      material.opacity = pbr.at("baseColorFactor").at(3).get<double>();
    if (!pbr.contains("metallicRoughnessTexture")) {
      material.metallic = pbr.value("metallicFactor", 1.0);
      material.roughness = pbr.value("roughnessFactor", 1.0);
    }
    const json& strength = member(member(source, "extensions"), "KHR_materials_emissive_strength");
    material.emission =
        strength.value("emissiveStrength", 1.0) * color_at(source, "emissiveFactor", {0, 0, 0});
    material.color_map = map_at(document, pbr, "baseColorTexture", images);
    material.normal_map = map_at(document, source, "normalTexture", images);
    material.emission_map = map_at(document, source, "emissiveTexture", images);
    materials.push_back(std::move(material));
  }
  return materials;
}

}  // namespace fracture::outputs
