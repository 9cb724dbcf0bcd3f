// Looks: materials for meshes that have none, as solid textures (Perlin, "An Image Synthesizer", 1985;
// Peachey, "Solid Texturing of Complex Surfaces", 1985). They are functions of the position in the whole
// object, so a cut through wood continues the rings of the outside. They change only the picture, never the
// mesh.
#pragma once

#include <array>
#include <string_view>

#include "client/render/model.hpp"
#include "common/base/error.hpp"

namespace fracture::render {

/// In the order of shaders/looks.glsl. Grey keeps the file's own roughness, metalness and transparency, but
/// not their colours and relief: cut faces are as bright as before, and the whole outside has one brightness.
enum class SolidLook {
  kNone,
  kGlass,
  kWood,
  kConcrete,
  kStone,
  kBrick,
  kCeramic,
  kMetal,
  kIce,
  kPlaster,
  kGrey
};

inline constexpr std::array<std::string_view, 11> kLookNames = {
    "none", "glass", "wood", "concrete", "stone", "brick", "ceramic", "metal", "ice", "plaster", "grey"};

/// The look with this name. kBadParameter lists the names.
Expected<SolidLook> look_by_name(std::string_view name);

/// The material that the shader gets before the solid texture; `source` itself without a look.
Material with_look(const Material& source, SolidLook look);

}  // namespace fracture::render
