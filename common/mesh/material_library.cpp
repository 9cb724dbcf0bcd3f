#include "common/mesh/material_library.hpp"

#include <algorithm>

#include "common/mesh/copied_limits.hpp"

namespace fracture {
namespace {

using nlohmann::json;

bool is_index(const json& value, std::size_t count) {
  return value.is_number_unsigned() && value.get<std::uint64_t>() < count;
}

}  // namespace

std::vector<std::size_t> looks_of(const MaterialLibrary& library, std::size_t material) {
  std::vector<std::size_t> looks{material};
  if (material >= library.variant_mappings.size()) return looks;
  const json& extension = library.variant_mappings[material];
  if (const auto mappings = extension.find("mappings"); mappings != extension.end())
    for (const json& mapping : *mappings) looks.push_back(mapping["material"].get<std::size_t>());
  return looks;
}

// Each primitive of a fragment has a copy of its mappings, so long ones do not fit either.
bool has_sound_variants(const MaterialLibrary& library) {
  const std::size_t materials = library.materials.size(), variants = library.variants.size();
  if (!library.variant_mappings.empty() && library.variant_mappings.size() != materials) return false;
  return std::all_of(
      library.variant_mappings.begin(), library.variant_mappings.end(), [&](const json& extension) {
        const auto mappings = extension.find("mappings");
        if (mappings == extension.end()) return extension.empty();
        return mappings->is_array() && mappings->dump().size() <= kMostMappings &&
               std::all_of(mappings->begin(), mappings->end(), [&](const json& mapping) {
                 const auto material = mapping.find("material"), shown = mapping.find("variants");
                 return mapping.is_object() && material != mapping.end() && is_index(*material, materials) &&
                        shown != mapping.end() && shown->is_array() &&
                        std::all_of(shown->begin(), shown->end(),
                                    [&](const json& variant) { return is_index(variant, variants); });
               });
      });
}

}  // namespace fracture
