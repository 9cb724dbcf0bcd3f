// The base colour of a glTF material, as far as a mean needs it: factor, texture, and where on it (glTF 2.0,
// 3.9.2 and 3.8; KHR_texture_transform; KHR_materials_pbrSpecularGlossiness, whose diffuse colour it is).
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/vec.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// What a texture shows outside [0, 1).
enum class Wrap { kRepeat, kMirror, kClamp };

/// `wrapped(u, n)` is the pixel, below n, that a texture coordinate shows.
std::uint32_t wrapped(double coordinate, Wrap wrap, std::uint32_t pixels);

struct BaseColorTexture {
  std::uint32_t image = 0;  ///< into MaterialLibrary::images
  std::uint32_t uv_set = 0;
  std::array<Wrap, 2> wrap{};
  /// (u, v, 1) to texture coordinates, KHR_texture_transform.
  std::array<std::array<double, 3>, 2> transform{{{1, 0, 0}, {0, 1, 0}}};

  std::array<double, 2> place(const Vec2f& uv) const;
};

struct BaseColor {
  Vec3d factor{1, 1, 1};  ///< linear, each 0 … 1
  std::optional<BaseColorTexture> texture;
  bool weigh_opacity = false;  ///< of the texture: alphaMode is MASK or BLEND
  bool translucent = false;    ///< alphaMode is BLEND, or KHR_materials_transmission lets light through
};

/// Of library.materials[k]. What glTF does not allow counts as not there.
BaseColor base_color(const MaterialLibrary& library, std::size_t material);

}  // namespace fracture
