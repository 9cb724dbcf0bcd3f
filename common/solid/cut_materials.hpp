// Materials of triangles that are cuts, in addition to the materials of the source.
#pragma once

#include <cstdint>

#include "common/solid/solid.hpp"

namespace fracture {

/// Material of cuts between the bricks of masonry (BrickPattern::mortar). It is kept when a fragment is
/// fractured again.
inline constexpr std::uint32_t kMortarMaterial = 0xfffffffcu;

inline constexpr bool is_of_cuts(std::uint32_t material) {
  return material == kInteriorMaterial || material == kMortarMaterial;
}

}  // namespace fracture
