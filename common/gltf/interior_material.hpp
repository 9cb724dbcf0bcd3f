// The material of the cut faces.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/base/error.hpp"
#include "common/base/vec.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// What the inside looks like. Whatever is not set comes from the source's material named by `material`, or
/// else from a plain matt grey called "Interior".
struct InteriorLook {
  std::string material{};             ///< name or index of a material of the source, whose look is reused
  std::optional<std::string> name{};  ///< of the material in the file
  std::optional<Vec3d> color{};  ///< base colour, linear, 0 … 1; replaces the reused base colour texture
  std::optional<double> roughness{};  ///< 0 … 1
  std::optional<double> metallic{};   ///< 0 … 1
  friend bool operator==(const InteriorLook&, const InteriorLook&) = default;
};

/// A glTF material object for GltfOptions::interior_material. A reused material is called
/// "Interior_<its name>", so that tools still tell cut faces from the outside; its textures tile with the
/// planar UVs of the cuts, one repeat a metre. kBadParameter (`interior_material`) with the names there are
/// in extra.known when the source has no such material.
Expected<nlohmann::json> interior_material(const InteriorLook& look, const MaterialLibrary& library);

/// The matt grey.
nlohmann::json plain_interior_material();

/// "#rrggbb" in sRGB (IEC 61966-2-1) to linear components; nothing for any other text.
std::optional<Vec3d> linear_color(std::string_view srgb_hex);

}  // namespace fracture
