// Better-shaped caps: the triangulation of a facet made constrained Delaunay by edge flips (Lawson 1977), its
// loops being the constraints. Ears and monotone stacks leave slivers where many loop points lie on a line
// (an arc of cuts along one input edge); flips turn them towards the inside.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

/// Does d lie strictly inside the circle through the counter-clockwise a, b, c? Exact for coordinates that differ by
/// less than 2^26.
bool in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d);

/// Flips inner edges of `triangles` (each inner edge is used once in either direction, boundary edges once)
/// until each is locally Delaunay, exactly decided, or the flips run out (a bound of kFlipsPerTriangle each
/// keeps it linear). Only strictly convex quadrilaterals are flipped, so no triangle is turned over that was
/// not before; the set of boundary edges and the number of triangles stay. Throws Interrupted.
inline constexpr std::size_t kFlipsPerTriangle = 8;
void flip_to_delaunay(std::span<const LatticePoint> points, std::span<std::array<std::uint32_t, 3>> triangles,
                      const Execution& execution = kUninterrupted);

}  // namespace fracture
