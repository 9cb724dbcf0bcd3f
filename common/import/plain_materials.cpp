#include "common/import/plain_materials.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/id.hpp"
#include "common/import/text_encoding.hpp"

namespace fracture {
namespace {

using nlohmann::json;

double unit_interval(float value) {
  return std::isfinite(value) ? std::clamp(static_cast<double>(value), 0.0, 1.0) : 1.0;
}

/// Rounds to a few decimal digits, because floats have no more, and 0.8 must not become 0.800000011920929.
double short_share(float value) { return std::round(unit_interval(value) * 1e6) / 1e6; }

json short_color(const std::array<float, 3>& color) {
  return {short_share(color[0]), short_share(color[1]), short_share(color[2])};
}

}  // namespace

json to_gltf(const PlainMaterial& source, const FindTexture& find_texture) {
  const auto first_of = [&find_texture](const std::vector<std::string>& names) {
    for (const std::string& name : names)
      if (const std::uint32_t found = find_texture(name); found != kNoIndex) return found;
    return kNoIndex;
  };
  json material = json::object();
  if (!source.name.empty()) material["name"] = name_as_utf8(source.name);
  json pbr = {{"metallicFactor", 0}};
  const double alpha = short_share(source.opacity);
  pbr["baseColorFactor"] = short_color(source.color);
  pbr["baseColorFactor"].push_back(alpha);
  if (alpha < 1) material["alphaMode"] = "BLEND";
  if (source.metallic) pbr["metallicFactor"] = short_share(*source.metallic);
  if (source.roughness) {
    pbr["roughnessFactor"] = short_share(*source.roughness);
  } else if (source.shininess && std::isfinite(*source.shininess) && *source.shininess > 0) {
    // Blinn-Phong exponent n to roughness: alpha = roughness^2 = sqrt(2 / (n + 2)) (Walter et al. 2007).
    pbr["roughnessFactor"] = short_share(
        static_cast<float>(std::sqrt(std::sqrt(2.0 / (static_cast<double>(*source.shininess) + 2.0)))));
  }
  if (source.emission[0] > 0 || source.emission[1] > 0 || source.emission[2] > 0)
    material["emissiveFactor"] = short_color(source.emission);
  if (source.two_sided) material["doubleSided"] = true;

  if (const std::uint32_t base = first_of(source.color_maps); base != kNoIndex)
    pbr["baseColorTexture"] = {{"index", base}};
  if (const std::uint32_t normal = first_of(source.normal_maps); normal != kNoIndex)
    material["normalTexture"] = {{"index", normal}};
  if (const std::uint32_t glow = first_of(source.emission_maps); glow != kNoIndex) {
    material["emissiveTexture"] = {{"index", glow}};
    if (!material.contains("emissiveFactor")) material["emissiveFactor"] = {1, 1, 1};
  }
  material["pbrMetallicRoughness"] = std::move(pbr);
  return material;
}

}  // namespace fracture
