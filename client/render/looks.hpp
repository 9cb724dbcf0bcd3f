// Looks: materials for meshes that bring none, as solid textures (Perlin, "An Image Synthesizer", 1985;
// Peachey, "Solid Texturing of Complex Surfaces", 1985). They are functions of the place in the whole object,
// so a cut through wood shows the rings that the outside promises. They change the picture only, never the
// mesh.
#pragma once

#include <array>
#include <string_view>

#include "client/render/model.hpp"
#include "common/base/error.hpp"

namespace fracture::render {

/// In the order of shaders/looks.glsl. Grey is the file's own materials without their colours and their
/// relief: as rough, as metallic and as clear as they are, cuts as light, the outside of one lightness.
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

/// kBadOption with the names there are.
Expected<SolidLook> look_by_name(std::string_view name);

/// What the shader gets before the solid texture: `source` where there is no look.
Material with_look(const Material& source, SolidLook look);

}  // namespace fracture::render
