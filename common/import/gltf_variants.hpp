// Material variants of glTF (KHR_materials_variants, ratified extension of Khronos).
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "common/mesh/dropped.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {

/// Reads the document's variants and the mappings of its primitives into a library that has the document's materials. A triangle
/// knows only its material. So if primitives with one material have different mappings, the material is appended again for each
/// further mapping, and the `material` of these primitives is changed in the document. Adds to `dropped`: mappings that name a
/// material or a variant that does not exist, and all mappings of a primitive that has no material, or more than kMostMappings
/// bytes of them. If all lists of the library together take more than kMaxLibraryBytes, the variants are dropped.
void read_variants(nlohmann::json& document, MaterialLibrary& library, std::vector<Dropped>& dropped);

/// Whether the document has a list of variants, so that read_variants() keeps or lists them.
bool has_variants(const nlohmann::json& document);

}  // namespace fracture
