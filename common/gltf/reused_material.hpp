// A material of the source as the look of cut faces.
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
  Vec3d color;              ///< linear: its base colour on the whole
};

/// `wanted`: a name, or else an index. `keep_textures`: also those that do not repeat on the source, which otherwise
/// give way to their mean. kBadParameter (`interior_material`). Throws Interrupted.
Expected<ReusedMaterial> reused_material(const std::string& wanted, bool keep_textures, const Mesh& mesh,
                                         const Execution& execution);

/// pbrMetallicRoughness as an object, made one where it is none, with a base colour of four numbers.
nlohmann::json& sound_pbr(nlohmann::json& material);

/// Sets the base colour, in the place of whatever colour, texture or older model of reflection there is.
void set_base_color(nlohmann::json& material, const Vec3d& linear);
/// Below 1 the material is blended, at 1 it is opaque.
void set_opacity(nlohmann::json& material, double opacity);

}  // namespace fracture
