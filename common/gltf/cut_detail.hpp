// Relief for cut faces: small textures that repeat without a seam, made by rule.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace fracture {

enum class CutDetail { kNone, kStone, kConcrete, kWood, kBrick };

inline constexpr std::string_view kCutDetailNames[] = {"none", "stone", "concrete", "wood", "brick"};

/// A tangent-space normal map (glTF 2.0, 3.9.3) and a map of roughness (its green channel, 3.9.2; metallic 0 in
/// blue), both PNG of kDetailSide x kDetailSide pixels.
struct DetailMaps {
  std::vector<std::uint8_t> normal, roughness;
};

inline constexpr std::uint32_t kDetailSide = 256;

/// Made at the first call, by gradient noise (Perlin 2002) on a lattice that repeats, in octaves that halve: the same
/// bytes everywhere. Not of kNone.
const DetailMaps& detail_maps(CutDetail detail);
/// They were made before.
bool has_detail_maps(CutDetail detail);

}  // namespace fracture
