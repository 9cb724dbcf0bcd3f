// The triangulation of a ring whose triangles have the least area together: none is turned over where any
// triangulation of the ring has none, whatever touches whatever.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/triangulate.hpp"

namespace fracture {

/// Appends n - 2 triangles of the ring of n corners, of which none has a corner twice, so that the sum of
/// their absolute areas is least (dynamic programming over sub-rings: Gilbert 1979; Klincsek 1980). False,
/// with nothing appended, where every triangulation has such a triangle. n cubed: for rings of some dozens.
bool triangulate_least_area(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                            std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace fracture
