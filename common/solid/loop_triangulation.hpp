// Triangulation of a closed loop in space over its own vertices.
//
// Small loops (up to kSmallLoop corners) get the triangulation of least area (Barequet & Sharir 1995,
// "Filling gaps in the boundary of a polyhedron": dynamic programming over sub-loops), which is a proper one
// for every planar simple loop and the natural one for a bent loop. Larger loops are projected along their
// mean normal and cut by ears, shortest diagonal first (Meisters 1975); reflex corners stand in a grid, so
// the cost is near-linear. Where no proper ear is left (the projection crosses itself) the shortest convex
// corner is cut anyway: any triangulation closes the surface, only its shape is poor.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"

namespace fracture::solid_detail {

inline constexpr std::size_t kSmallLoop = 28;  ///< the cubic method costs about 0.1 ms here

/// Three corners of a loop.
using LoopTriangle = std::array<std::uint32_t, 3>;

/// n - 2 triangles for n >= 3 corners, in the loop's direction: each side (i, i + 1) is
/// used once in that direction and each diagonal once in each. Corners may coincide; then triangles without
/// area may appear.
std::vector<LoopTriangle> triangulate_loop(const std::vector<Vec3f>& corners, const Execution& execution);

}  // namespace fracture::solid_detail
