// Divides rings that pass a position more than once into rings that do not. Lattices of sites and fused
// polygons have corners with different names at one position: two notches whose tips touch, or four sites on
// a circle. When ears are cut, a touching point either blocks or does not, so triangles may be turned over
// there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/triangulate.hpp"

namespace fracture {

/// Removes all but the first of successive corners at the same position. Appends triangles without area:
/// together with a triangulation of the rest, they use every edge of `ring` exactly once.
std::vector<std::uint32_t> leave_out_repeated(std::span<const LatticePoint> points,
                                              std::span<const std::uint32_t> ring,
                                              std::vector<std::array<std::uint32_t, 3>>& triangles);

/// Divides the ring wherever it returns to a position and the region enclosed since its last visit is on its
/// left. A diagonal of length zero joins the two visits. (If the region is on its right, it is a hole that
/// touches the ring, and stays with it.) Then removes all but one of successive corners at the same position.
/// Appends the remaining rings of at least three corners, and the triangles without area for the diagonals
/// and the removed corners. Together with the triangles of all rings, they use every edge of `ring` exactly
/// once. O(n log n).
void divide_pinched_ring(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                         std::vector<std::vector<std::uint32_t>>& rings,
                         std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace fracture
