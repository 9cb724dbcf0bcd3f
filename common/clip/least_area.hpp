// The triangulation of a ring with the least total area. It has no triangle that is turned over if any
// triangulation of the ring has none, even if parts of the ring touch.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/triangulate.hpp"

namespace fracture {

/// Appends n - 2 triangles of a ring of n corners, such that no triangle repeats a corner and the sum of
/// their absolute areas is minimal (dynamic programming over sub-rings: Gilbert 1979; Klincsek 1980). Returns
/// false and appends nothing if every triangulation repeats a corner. O(n³), for rings of some dozens of
/// corners.
bool triangulate_least_area(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                            std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace fracture
