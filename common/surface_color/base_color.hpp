// The base colour of a glTF material, as far as its mean requires: factor, texture, and the position on the
// texture (glTF 2.0, 3.9.2 and 3.8; KHR_texture_transform; the diffuse colour of
// KHR_materials_pbrSpecularGlossiness).
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/vec.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// How a texture continues outside [0, 1).
enum class Wrap { kRepeat, kMirror, kClamp };

/// `wrapped(u, n)` is the pixel, below n, for a texture coordinate.
std::uint32_t wrapped(double coordinate, Wrap wrap, std::uint32_t pixels);

struct BaseColorTexture {
  std::uint32_t image = 0;  ///< index into MaterialLibrary::images
  std::uint32_t uv_set = 0;
  std::array<Wrap, 2> wrap{};
  /// Maps (u, v, 1) to texture coordinates (KHR_texture_transform).
  std::array<std::array<double, 3>, 2> transform{{{1, 0, 0}, {0, 1, 0}}};

  std::array<double, 2> place(const Vec2f& uv) const;
};

struct BaseColor {
  Vec3d factor{1, 1, 1};  ///< linear, each 0 … 1
  std::optional<BaseColorTexture> texture;
  bool weigh_opacity = false;  ///< opacity of the texture matters: alphaMode is MASK or BLEND
  bool translucent = false;    ///< alphaMode is BLEND, or KHR_materials_transmission transmits light
};

/// The base colour of library.materials[k]. Values that glTF does not allow are ignored.
BaseColor base_color(const MaterialLibrary& library, std::size_t material);

}  // namespace fracture
