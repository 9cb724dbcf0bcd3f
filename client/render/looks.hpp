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

/// In the order of shaders/looks.glsl.
enum class SolidLook { kNone, kGlass, kWood, kConcrete, kStone, kBrick, kCeramic, kMetal, kIce, kPlaster };

inline constexpr std::array<std::string_view, 10> kLookNames = {
    "none", "glass", "wood", "concrete", "stone", "brick", "ceramic", "metal", "ice", "plaster"};

/// kBadOption with the names there are.
Expected<SolidLook> look_by_name(std::string_view name);

/// What the shader gets before the solid texture: `source` where there is no look.
Material with_look(const Material& source, SolidLook look);

}  // namespace fracture::render
