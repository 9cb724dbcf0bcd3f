// Materials of triangles that are cuts, beside those of the source.
#pragma once

#include <cstdint>

#include "common/solid/solid.hpp"

namespace fracture {

/// Of cuts between the bricks of a masonry (BrickPattern::mortar). A fragment that is fractured again keeps them.
inline constexpr std::uint32_t kMortarMaterial = 0xfffffffcu;

inline constexpr bool is_of_cuts(std::uint32_t material) {
  return material == kInteriorMaterial || material == kMortarMaterial;
}

}  // namespace fracture
