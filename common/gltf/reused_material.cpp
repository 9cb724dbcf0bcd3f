#include "common/gltf/reused_material.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/base/nearest_name.hpp"
#include "common/base/pacer.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/mesh/material_library.hpp"
#include "common/surface_color/base_color.hpp"

namespace fracture {
namespace {

using nlohmann::json;

std::string name_of(const json& material) {
  const auto name = material.find("name");
  return name != material.end() && name->is_string() ? name->get<std::string>() : std::string();
}

/// Returns the first material with this name, or otherwise the one with this index; kNoIndex if there is neither.
std::uint32_t find_material(const std::string& wanted, const json& materials) {
  for (std::uint32_t k = 0; k < materials.size(); ++k)
    if (name_of(materials[k]) == wanted) return k;
  std::uint32_t index = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
  const bool number = error == std::errc{} && end == wanted.data() + wanted.size();
  return number && index < materials.size() ? index : kNoIndex;
}

/// The region of a texture that the triangles of a material show, and their colours.
struct Shown {
  std::array<double, 2> low{HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL};
  double uv_area = 0, area = 0;
  std::array<double, 3> color{};

  /// Whether the texture is meant to repeat: triangles show more than all of it along an axis, or twice its area.
  bool repeats() const {
    constexpr double kWhole = 1.02, kTwice = 2;
    return high[0] - low[0] > kWhole || high[1] - low[1] > kWhole || uv_area >= kTwice;
  }
};

void look_at(const Mesh& mesh, std::uint32_t slot, const std::optional<BaseColorTexture>& texture,
             Shown& shown, Pacer& pacer) {
  const std::vector<Vec2f>* uvs = texture && texture->uv_set < mesh.attributes.uvs.size()
                                      ? &mesh.attributes.uvs[texture->uv_set]
                                      : nullptr;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    pacer.step();
    if (mesh.material[t] != slot) continue;
    const auto& [a, b, c] = mesh.triangles[t];
    if (uvs != nullptr) {
      std::array<std::array<double, 2>, 3> uv{texture->place((*uvs)[a]), texture->place((*uvs)[b]),
                                              texture->place((*uvs)[c])};
      for (const auto& corner : uv)
        for (std::size_t k = 0; k < 2; ++k) {
          shown.low[k] = std::min(shown.low[k], corner[k]);
          shown.high[k] = std::max(shown.high[k], corner[k]);
        }
      shown.uv_area += std::fabs((uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) -
                                 (uv[1][1] - uv[0][1]) * (uv[2][0] - uv[0][0])) /
                       2;
    }
    if (mesh.triangle_color.empty() || mesh.triangle_color[t].known == 0) continue;
    const Vec3d corner = to_double(mesh.positions[a]);
    const double size =
        length(cross(to_double(mesh.positions[b]) - corner, to_double(mesh.positions[c]) - corner));
    for (std::size_t k = 0; k < 3; ++k) shown.color[k] += size * mesh.triangle_color[t].light[k] / 65535;
    shown.area += size;
  }
}

double number_or(const json& object, const char* name, double otherwise) {
  const auto it = object.find(name);
  return it != object.end() && it->is_number() ? it->get<double>() : otherwise;
}

/// Returns the material without its textures. If roughness and metalness had one, they get default values.
json flat(const json& source, const Vec3d& color) {
  json material = {{"name", source["name"]}};
  json copy = source;
  const json& pbr = sound_pbr(copy);
  const bool unknown = pbr.contains("metallicRoughnessTexture");
  json& own = material["pbrMetallicRoughness"];
  own["metallicFactor"] = unknown ? 0 : std::clamp(number_or(pbr, "metallicFactor", 1), 0.0, 1.0);
  own["roughnessFactor"] = unknown ? 0.9 : std::clamp(number_or(pbr, "roughnessFactor", 1), 0.0, 1.0);
  set_base_color(material, color);
  const double opacity = pbr["baseColorFactor"][3].get<double>();
  if (source.value("alphaMode", json()) == "BLEND") set_opacity(material, opacity);
  return material;
}

}  // namespace

nlohmann::json& sound_pbr(json& material) {
  json& pbr = material["pbrMetallicRoughness"];
  if (!pbr.is_object()) pbr = json::object();
  json& factor = pbr["baseColorFactor"];
  const bool sound = factor.is_array() && factor.size() == 4 &&
                     std::all_of(factor.begin(), factor.end(), [](const json& c) { return c.is_number(); });
  if (!sound) factor = {1, 1, 1, 1};
  return pbr;
}

void set_base_color(json& material, const Vec3d& linear) {
  json& pbr = sound_pbr(material);
  pbr.erase("baseColorTexture");
  // Four digits are more than a screen can show, and they keep the text short.
  for (std::size_t k = 0; k < 3; ++k)
    pbr["baseColorFactor"][k] = std::nearbyint(std::clamp(linear[static_cast<int>(k)], 0.0, 1.0) * 1e4) / 1e4;
  if (const auto extensions = material.find("extensions");
      extensions != material.end() && extensions->is_object()) {
    extensions->erase("KHR_materials_pbrSpecularGlossiness");  // readers that support it would use its colour
    if (extensions->empty()) material.erase("extensions");
  }
}

void set_opacity(json& material, double opacity) {
  sound_pbr(material)["baseColorFactor"][3] = opacity;
  material.erase("alphaCutoff");
  if (opacity < 1)
    material["alphaMode"] = "BLEND";
  else
    material.erase("alphaMode");
}

Expected<ReusedMaterial> reused_material(const std::string& wanted, bool keep_textures, const Mesh& mesh,
                                         const Execution& execution) {
  const json& materials = mesh.library->materials;
  const std::uint32_t slot = find_material(wanted, materials);
  if (slot == kNoIndex) {
    json known = json::array();
    for (const json& material : materials) known.push_back(name_of(material));
    const std::size_t count = known.size();
    std::string detail = "'interior_material': the mesh has no material '" + wanted + "'";
    if (count == 0)
      detail += "; it has no materials. Leave 'interior_material' out.";
    else if (count == 1)
      detail += "; its only material is '" + known[0].get<std::string>() + "'.";
    else
      detail += "." + printable(did_you_mean(wanted, known.get<std::vector<std::string>>())) +
                " Use one of its " + grouped(count) + " materials, which 'known' lists.";
    return fail(ErrorCode::kBadParameter, std::move(detail), "interior_material",
                {{"known", std::move(known)}});
  }
  const BaseColor own = base_color(*mesh.library, slot);
  Pacer pacer(execution);
  Shown shown;
  look_at(mesh, slot, own.texture, shown, pacer);
  if (mesh.passed_through) look_at(*mesh.passed_through, slot, own.texture, shown, pacer);
  ReusedMaterial reused{materials[slot], own.factor};
  if (shown.area > 0) reused.color = (1 / shown.area) * Vec3d{shown.color[0], shown.color[1], shown.color[2]};
  const std::string name = name_of(reused.material);
  reused.material["name"] = name.empty() ? "Interior" : "Interior_" + name;
  if (!keep_textures && own.texture && shown.area > 0 && !shown.repeats())
    reused.material = flat(reused.material, reused.color);
  return reused;
}

}  // namespace fracture
