// Reuses one of the source's materials for cut faces.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

struct ReusedMaterial {
  nlohmann::json material;  ///< glTF material object
  Vec3d color;              ///< linear: its mean base colour
};

/// `wanted`: a name, or otherwise an index. `keep_textures`: keep textures even if they do not repeat on the source;
/// otherwise their mean replaces them. Error: kBadParameter (`interior_material`). Throws Interrupted.
Expected<ReusedMaterial> reused_material(const std::string& wanted, bool keep_textures, const Mesh& mesh,
                                         const Execution& execution);

/// Returns pbrMetallicRoughness with a base colour of four numbers. Replaces malformed values.
nlohmann::json& sound_pbr(nlohmann::json& material);

/// Sets the base colour. Removes the base colour texture and KHR_materials_pbrSpecularGlossiness.
void set_base_color(nlohmann::json& material, const Vec3d& linear);
/// Sets the opacity. Below 1 the material is blended; at 1 it is opaque.
void set_opacity(nlohmann::json& material, double opacity);

}  // namespace fracture
