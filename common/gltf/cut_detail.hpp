// Relief for cut faces: small procedural textures that repeat without a seam.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace fracture {

enum class CutDetail { kNone, kStone, kConcrete, kWood, kBrick };

inline constexpr std::string_view kCutDetailNames[] = {"none", "stone", "concrete", "wood", "brick"};

/// A tangent-space normal map (glTF 2.0, 3.9.3) and a roughness map (green channel, 3.9.2; the blue channel is metallic 0).
/// Both are PNG images of kDetailSide x kDetailSide pixels.
struct DetailMaps {
  std::vector<std::uint8_t> normal, roughness;
};

inline constexpr std::uint32_t kDetailSide = 256;

/// Returns the maps, which the first call makes: gradient noise (Perlin 2002) on a repeating lattice, in octaves of halved
/// cell size. Every machine makes the same bytes. `detail` must not be kNone.
const DetailMaps& detail_maps(CutDetail detail);
/// Whether the maps have already been made.
bool has_detail_maps(CutDetail detail);

}  // namespace fracture
