// Rings that pass a place more than once, as rings that do not. Lattices of sites and fused polygons have
// corners at one place under different names: two notches whose tips touch, four sites on a circle. Ears know
// a touch only as a point in their way, or not in it, and may turn triangles over there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/triangulate.hpp"

namespace fracture {

/// The ring without all but the first of successive corners at one place. Appends triangles without area:
/// with those of what remains, every edge of `ring` is used exactly once.
std::vector<std::uint32_t> leave_out_repeated(std::span<const LatticePoint> points,
                                              std::span<const std::uint32_t> ring,
                                              std::vector<std::array<std::uint32_t, 3>>& triangles);

/// Divides the ring wherever it comes back to a place and what it encloses since its last visit lies on its
/// left; a diagonal without length joins the two visits. (Where it lies on its right it is a hole that
/// touches; that stays with its ring.) Then leaves out all but one of successive corners at one place.
/// Appends the rings that remain, each of three corners or more, and the triangles without area that the
/// diagonals and the corners left out take: with the triangles of all rings, every edge of `ring` is used
/// exactly once. n log n.
void divide_pinched_ring(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                         std::vector<std::vector<std::uint32_t>>& rings,
                         std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace fracture
