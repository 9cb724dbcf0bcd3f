#include "common/gltf/interior_material.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/gltf/reused_material.hpp"
#include "common/mesh/material_library.hpp"
#include "common/surface_color/color_groups.hpp"

namespace fracture {
namespace {

using nlohmann::json;

const Vec3d kGrey{0.55, 0.5, 0.45};
/// Cuts look alike if their colours differ by at most this in each component, in square roots of linear light.
constexpr double kAlike = 0.06;

/// Share of the outside's colour (InteriorLook::mix). If not set: 1, or 0 if a colour or a material is given.
double share_of_outside(const InteriorLook& look) {
  if (look.choice == InteriorChoice::kPlain) return 0;
  return look.mix.value_or(look.color || !look.material.empty() ? 0 : 1);
}

/// Adds the textures of detail_maps() if the material has none yet. `texture`: index of the first one.
void add_detail(json& material, std::size_t texture) {
  json& pbr = sound_pbr(material);
  if (!material.contains("normalTexture")) material["normalTexture"] = {{"index", texture}};
  if (!pbr.contains("metallicRoughnessTexture")) pbr["metallicRoughnessTexture"] = {{"index", texture + 1}};
}

/// Returns the look of all cuts, before the colours of the parts are mixed in.
Expected<ReusedMaterial> common_look(const InteriorLook& look, const Mesh& mesh, const Execution& execution) {
  ReusedMaterial base{plain_interior_material(), kGrey};
  if (!look.material.empty()) {
    auto reused = reused_material(look.material, look.choice == InteriorChoice::kTexture, mesh, execution);
    if (!reused) return reused;
    base = std::move(*reused);
  }
  if (look.name) base.material["name"] = *look.name;
  if (look.color) set_base_color(base.material, base.color = *look.color);
  if (look.roughness) sound_pbr(base.material)["roughnessFactor"] = *look.roughness;
  if (look.metallic) sound_pbr(base.material)["metallicFactor"] = *look.metallic;
  if (look.opacity) set_opacity(base.material, *look.opacity);
  if (look.detail != CutDetail::kNone && !look.has_maps)
    add_detail(base.material, mesh.library->textures.size());
  return base;
}

/// Makes names that no material of the source has. If a file of fragments is fractured again, it already has an "Interior",
/// so its new cuts get "Interior_2".
class FreeNames {
 public:
  explicit FreeNames(const json& materials) {
    for (const json& material : materials)
      if (const auto name = material.find("name"); name != material.end() && name->is_string())
        taken_.insert(name->get<std::string>());
  }
  /// Returns the stem with the lowest free number from `number` on. The number 1 is omitted.
  std::string take(const std::string& stem, std::size_t number) {
    for (;; ++number)
      if (const std::string name = number == 1 ? stem : stem + "_" + std::to_string(number);
          taken_.insert(name).second)
        return name;
  }

 private:
  std::set<std::string> taken_;
};

/// The colours of cuts of one kind of parts: opaque or translucent.
struct Kind {
  ColorHistogram colors;
  ColorGroups groups;
  std::uint32_t first = 0;  ///< index of its first material
};

class Mixer {
 public:
  Mixer(const InteriorLook& look, ReusedMaterial base, const Solid& solid, FreeNames& names, Pacer& pacer)
      : look_(look),
        base_(std::move(base)),
        solid_(solid),
        names_(names),
        pacer_(pacer),
        share_(share_of_outside(look)) {}

  InteriorMaterials run() {
    for (const Part& part : solid_.parts) {
      pacer_.step(8);
      if (is_mixed(part)) kinds_[is_clear(part)].colors.add(mixed(part), std::max(part.volume, 1e-30));
    }
    // Two materials are for parts of unknown colour: one opaque, one clear. Clear parts get a quarter of the others.
    const std::size_t most = kMostInteriorMaterials - 2, clear = kinds_[true].colors.empty() ? 0 : most / 4;
    make_materials(kinds_[false], most - clear, false);
    make_materials(kinds_[true], kinds_[false].colors.empty() ? most : clear, true);
    std::array<std::uint32_t, 2> of_unknown{kNoIndex, kNoIndex};
    for (const Part& part : solid_.parts) {
      pacer_.step(8);
      const bool clear_part = is_clear(part);
      if (is_mixed(part)) {
        const Kind& kind = kinds_[clear_part];
        result_.of_part.push_back(kind.first + kind.groups.of(mixed(part)));
        continue;
      }
      if (of_unknown[clear_part] == kNoIndex) of_unknown[clear_part] = add(base_.material, clear_part);
      result_.of_part.push_back(of_unknown[clear_part]);
    }
    if (result_.materials.empty()) add(base_.material, false);
    if (result_.materials.size() == 1) result_.of_part.clear();
    return std::move(result_);
  }

 private:
  bool is_mixed(const Part& part) const { return share_ > 0 && part.color; }
  bool is_clear(const Part& part) const { return part.translucent && !look_.opacity; }

  LinearColor mixed(const Part& part) const {
    LinearColor color;
    for (std::size_t k = 0; k < 3; ++k) {
      const double light =
          share_ * look_.shade * (*part.color)[k] / 65535 + (1 - share_) * base_.color[static_cast<int>(k)];
      color[k] = static_cast<std::uint16_t>(std::nearbyint(65535 * std::clamp(light, 0.0, 1.0)));
    }
    return color;
  }

  void make_materials(Kind& kind, std::size_t most, bool clear) {
    if (kind.colors.empty()) return;
    kind.groups = kind.colors.groups(most, kAlike);
    kind.first = static_cast<std::uint32_t>(result_.materials.size());
    for (const LinearColor& color : kind.groups.means) {
      json material = base_.material;
      set_base_color(material, (1.0 / 65535) * Vec3d{1.0 * color[0], 1.0 * color[1], 1.0 * color[2]});
      add(std::move(material), clear);
    }
  }

  std::uint32_t add(json material, bool clear) {
    const std::size_t number = result_.materials.size();
    if (clear) set_opacity(material, kClearOpacity);
    material["name"] = names_.take(material["name"].get<std::string>(), number + 1);
    result_.materials.push_back(std::move(material));
    return static_cast<std::uint32_t>(number);
  }

  const InteriorLook& look_;
  const ReusedMaterial base_;
  const Solid& solid_;
  FreeNames& names_;
  Pacer& pacer_;
  const double share_;
  std::array<Kind, 2> kinds_;  ///< [translucent]
  InteriorMaterials result_{.uvs = look_.uvs, .detail = look_.has_maps ? CutDetail::kNone : look_.detail};
};

/// Returns the material of inner sides of walls. It looks like the cuts, but without textures: all its UVs are 0.
json cavity_of(json cut, const Vec3d& base_color, std::string name) {
  json pbr = sound_pbr(cut);
  if (pbr.contains("baseColorTexture")) set_base_color(cut, base_color);
  json cavity = {{"name", std::move(name)}};
  for (const char* factor : {"baseColorFactor", "metallicFactor", "roughnessFactor"})
    if (cut["pbrMetallicRoughness"].contains(factor))
      cavity["pbrMetallicRoughness"][factor] = cut["pbrMetallicRoughness"][factor];
  if (cut.contains("alphaMode")) cavity["alphaMode"] = cut["alphaMode"];
  return cavity;
}

/// Returns crushed ice. It scatters nearly all light, like snow: its albedo is 0.8 to 0.9 (Wiscombe and Warren 1980, A model
/// for the spectral albedo of snow).
json crushed_of(const json& cut, FreeNames& names) {
  return {{"name", names.take(cut["name"].get<std::string>() + "_Crushed", 1)},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {0.85, 0.88, 0.9, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.9}}}};
}

/// Returns mortar: sand and lime or cement, so it is matt. It has no relief.
json mortar_of(const json& cut, const Vec3d& color, FreeNames& names) {
  return {{"name", names.take(cut["name"].get<std::string>() + "_Mortar", 1)},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {color.x, color.y, color.z, 1}},
            {"metallicFactor", 0},
            {"roughnessFactor", 0.95}}}};
}

}  // namespace

json plain_interior_material() {
  return {{"name", "Interior"},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {kGrey.x, kGrey.y, kGrey.z, 1}},
            {"metallicFactor", 0},
            {"roughnessFactor", 0.9}}}};
}

Expected<InteriorMaterials> interior_materials(const InteriorLook& look, const Solid& solid,
                                               const Execution& execution, std::uint32_t pieces) {
  Expected<ReusedMaterial> base = common_look(look, *solid.source, execution);
  if (!base) return tl::unexpected(std::move(base.error()));
  Pacer pacer(execution);
  const Vec3d base_color = base->color;
  FreeNames names(look.name ? json::array() : solid.source->library->materials);
  InteriorMaterials made = Mixer(look, std::move(*base), solid, names, pacer).run();
  if (look.detail != CutDetail::kNone) made.in_relief = static_cast<std::uint32_t>(made.materials.size());
  if (solid.report.parts_hollowed > 0)
    for (const json& cut : made.materials)
      made.cavities.push_back(cavity_of(cut, base_color, names.take("Cavity", made.cavities.size() + 1)));
  if (look.mortar) {
    made.mortar = static_cast<std::uint32_t>(made.materials.size());
    made.materials.push_back(mortar_of(made.materials.front(), *look.mortar, names));
  }
  if (look.crushed > 0) {
    double volume = 0;
    for (const Part& part : solid.parts) {
      pacer.step();
      volume += part.volume;
    }
    made.crushed_below = look.crushed * volume / std::max(1u, pieces);
    made.materials.push_back(crushed_of(made.materials.front(), names));
  }
  return made;
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
    // Rounded to six digits, because the last bits of pow() differ between C libraries.
    const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    color[k] = std::nearbyint(linear * 1e6) / 1e6;
  }
  return color;
}

}  // namespace fracture
