#include "common/gltf/exterior_material.hpp"

#include <set>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/gltf/reused_material.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

using nlohmann::json;

/// Extensions that also describe how light interacts with a surface. The preset decides that, so they are removed.
constexpr const char* kOfOtherMaterials[] = {"KHR_materials_pbrSpecularGlossiness",
                                             "KHR_materials_transmission",
                                             "KHR_materials_volume",
                                             "KHR_materials_ior",
                                             "KHR_materials_clearcoat",
                                             "KHR_materials_sheen",
                                             "KHR_materials_specular",
                                             "KHR_materials_iridescence",
                                             "KHR_materials_anisotropy",
                                             "KHR_materials_unlit"};

void finish(json& material, const ExteriorLook& look) {
  json& pbr = sound_pbr(material);
  if (look.roughness || look.metallic) pbr.erase("metallicRoughnessTexture");
  if (look.roughness) pbr["roughnessFactor"] = *look.roughness;
  if (look.metallic) pbr["metallicFactor"] = *look.metallic;
  if (look.opacity) set_opacity(material, *look.opacity);
  if (const auto extensions = material.find("extensions");
      extensions != material.end() && extensions->is_object()) {
    for (const char* name : kOfOtherMaterials) extensions->erase(name);
    if (extensions->empty()) material.erase("extensions");
  }
}

/// "Exterior", with a number if a material of the source has that name, as in an answer that is fractured again.
std::string free_name(const json& materials, Pacer& pacer) {
  std::set<std::string> taken;
  for (const json& material : materials) {
    pacer.step(16);
    if (const auto name = material.find("name"); name != material.end() && name->is_string())
      taken.insert(name->get<std::string>());
  }
  std::string name = "Exterior";
  for (int number = 2; taken.contains(name); ++number) {
    pacer.step(16);
    name = "Exterior_" + std::to_string(number);
  }
  return name;
}

json bare(const ExteriorLook& look, const Mesh& source, Pacer& pacer) {
  json material = {{"name", free_name(source.library->materials, pacer)}};
  const bool colored = !source.attributes.colors.empty();
  set_base_color(material, colored ? Vec3d{1, 1, 1} : look.color.value_or(Vec3d{1, 1, 1}));
  finish(material, look);
  return material;
}

}  // namespace

ExteriorMaterials exterior_materials(const ExteriorLook& look, const Mesh& source,
                                     const Execution& execution) {
  ExteriorMaterials made;
  if (!look.any() || look.choice == ExteriorChoice::kAsset) return made;
  Pacer pacer(execution);
  const json& own = source.library->materials;
  std::vector<bool> used(own.size() + 1, false);
  for (const std::uint32_t material : source.material) {
    pacer.step();
    if (material < own.size())
      used[material] = true;
    else if (material == kNoIndex)  // not the inner side of a wall, which looks like cuts
      used.back() = true;
  }
  made.of_source.assign(used.size(), kNoIndex);
  const auto add = [&](std::size_t slot, json material) {
    made.of_source[slot] = static_cast<std::uint32_t>(made.materials.size());
    made.materials.push_back(std::move(material));
  };
  for (std::size_t k = 0; look.choice == ExteriorChoice::kMaterial && k < own.size(); ++k) {
    pacer.step(16);
    if (!used[k]) continue;
    json material = own[k];
    finish(material, look);
    add(k, std::move(material));
  }
  if (used.back()) add(own.size(), bare(look, source, pacer));
  return made;
}

}  // namespace fracture
