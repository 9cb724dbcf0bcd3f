#include "common/gltf/part_materials.hpp"

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

/// Returns the index of the first equal look, for each look.
template <class Look>
std::vector<std::uint32_t> first_equal(const std::vector<Look>& looks) {
  std::vector<std::uint32_t> first;
  for (const Look& look : looks)
    first.push_back(static_cast<std::uint32_t>(std::find(looks.begin(), looks.end(), look) - looks.begin()));
  return first;
}

/// Gives materials names that are not taken yet, by appending a number.
void make_unique(std::vector<nlohmann::json>& materials, std::set<std::string>& taken) {
  for (nlohmann::json& material : materials) {
    const std::string stem = material["name"].get<std::string>();
    std::string name = stem;
    for (std::size_t number = 2; !taken.insert(name).second; ++number)
      name = stem + "_" + std::to_string(number);
    material["name"] = name;
  }
}

/// Number of a look's materials that cuts of whole parts have; those of mortar and of crushed cuts follow.
std::size_t plain_count(const InteriorMaterials& made) {
  return made.materials.size() - (made.mortar != kNoIndex ? 1 : 0) - (made.crushed_below > 0 ? 1 : 0);
}

}  // namespace

Expected<InteriorMaterials> interior_materials_of_parts(const std::vector<InteriorLook>& looks,
                                                        const std::vector<std::uint32_t>& look_of_part,
                                                        const Solid& solid, const Execution& execution,
                                                        std::uint32_t pieces) {
  const std::vector<std::uint32_t> first = first_equal(looks);
  InteriorMaterials all;
  all.of_part.assign(look_of_part.size(), 0);
  all.looks.resize(looks.size());
  std::vector<nlohmann::json> special;  // mortar and crushed cuts
  double volume = 0;
  for (const Part& part : solid.parts) volume += part.volume;
  for (std::uint32_t k = 0; k < looks.size(); ++k) {
    execution.poll();
    if (first[k] != k) continue;
    Solid own;  // only what interior_materials() reads
    own.source = solid.source;
    own.report.parts_hollowed = solid.report.parts_hollowed;
    std::vector<std::size_t> parts;
    for (std::size_t p = 0; p < look_of_part.size(); ++p) {
      if (first[look_of_part[p]] != k) continue;
      parts.push_back(p);
      own.parts.push_back(solid.parts[p]);
    }
    if (parts.empty()) continue;
    Expected<InteriorMaterials> made = interior_materials(looks[k], own, execution, pieces);
    if (!made) return made;
    const auto begin = static_cast<std::uint32_t>(all.materials.size());
    for (std::size_t p = 0; p < parts.size(); ++p) all.of_part[parts[p]] = begin + made->of(p);
    const auto plain = static_cast<std::ptrdiff_t>(plain_count(*made));
    all.materials.insert(all.materials.end(), made->materials.begin(), made->materials.begin() + plain);
    all.cavities.insert(all.cavities.end(), made->cavities.begin(), made->cavities.end());
    if (all.materials.size() == static_cast<std::size_t>(plain)) {
      all.uvs = made->uvs;
      all.detail = made->detail;
    }
    InteriorMaterials::OfLook& look = all.looks[k];
    const auto keep = [&](std::uint32_t index) {
      special.push_back(std::move(made->materials[index]));
      return static_cast<std::uint32_t>(special.size() - 1);
    };
    if (made->mortar != kNoIndex) look.mortar = keep(made->mortar);
    if (made->crushed_below > 0) {
      look.crushed_below = looks[k].crushed * volume / std::max(1u, pieces);
      look.crushed = keep(static_cast<std::uint32_t>(made->materials.size() - 1));
    }
    if (made->in_relief > 0) all.in_relief = static_cast<std::uint32_t>(all.materials.size());
  }
  const auto plain = static_cast<std::uint32_t>(all.materials.size());
  for (InteriorMaterials::OfLook& look : all.looks)
    for (std::uint32_t* index : {&look.mortar, &look.crushed})
      if (*index != kNoIndex) *index += plain;
  for (nlohmann::json& material : special) all.materials.push_back(std::move(material));
  if (all.materials.empty()) all.materials.push_back(plain_interior_material());
  std::set<std::string> taken;
  make_unique(all.materials, taken);
  make_unique(all.cavities, taken);
  all.look_of_part.reserve(look_of_part.size());
  for (const std::uint32_t look : look_of_part) all.look_of_part.push_back(first[look]);
  return all;
}

ExteriorMaterials exterior_materials_of_parts(const std::vector<ExteriorLook>& looks,
                                              const std::vector<std::uint32_t>& look_of_part,
                                              const Solid& solid, const Execution& execution) {
  const std::vector<std::uint32_t> first = first_equal(looks);
  const std::size_t materials = solid.source->library->materials.size();
  std::vector<std::vector<bool>> used(looks.size(), std::vector<bool>(materials + 1, false));
  Pacer pacer(execution);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step();
    const std::uint32_t material = solid.material[t];
    if (material < materials || material == kNoIndex)
      used[first[look_of_part[solid.part[t]]]][std::min<std::size_t>(material, materials)] = true;
  }
  ExteriorMaterials all;
  all.looks.resize(looks.size());
  for (std::uint32_t k = 0; k < looks.size(); ++k) {
    if (first[k] != k) continue;
    Mesh own;  // only what exterior_materials() reads
    own.library = solid.source->library;
    if (!solid.source->attributes.colors.empty()) own.attributes.colors.resize(1);
    for (std::uint32_t m = 0; m <= materials; ++m)
      if (used[k][m]) own.material.push_back(m < materials ? m : kNoIndex);
    ExteriorMaterials made = exterior_materials(looks[k], own, execution);
    const auto begin = static_cast<std::uint32_t>(all.materials.size());
    for (std::uint32_t& index : made.of_source)
      if (index != kNoIndex) index += begin;
    all.looks[k] = std::move(made.of_source);
    for (nlohmann::json& material : made.materials) all.materials.push_back(std::move(material));
  }
  if (all.materials.empty()) return {};
  for (const std::uint32_t look : look_of_part) all.look_of_part.push_back(first[look]);
  return all;
}

}  // namespace fracture
