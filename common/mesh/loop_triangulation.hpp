// Triangulates a closed loop in space, using only its own vertices.
//
// Small loops (up to kSmallLoop corners) get the triangulation of least area, by dynamic programming over
// sub-loops (Barequet & Sharir 1995, "Filling gaps in the boundary of a polyhedron"). It is valid for every
// planar simple loop, and natural for a bent loop. Larger loops are projected along their mean normal and
// triangulated by cutting ears, shortest diagonal first (Meisters 1975). Their reflex corners are in a grid,
// so the cost is near-linear. If no proper ear is left (because the projection crosses itself), the convex
// corner with the shortest diagonal is cut anyway: any triangulation closes the surface, but its shape is
// poor.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"

namespace fracture::solid_detail {

inline constexpr std::size_t kSmallLoop = 28;  ///< the cubic method takes about 0.1 ms at this size

/// Three corners of a loop.
using LoopTriangle = std::array<std::uint32_t, 3>;

/// Returns n - 2 triangles for n >= 3 corners, in the loop's direction: each side (i, i + 1) is used once in
/// that direction, and each diagonal once in each direction. If corners coincide, triangles without area may
/// appear.
std::vector<LoopTriangle> triangulate_loop(const std::vector<Vec3f>& corners, const Execution& execution);

}  // namespace fracture::solid_detail
