// Improves the shape of caps: edge flips make the triangulation of a facet constrained Delaunay (Lawson
// 1977), with its loops as constraints. Ears and monotone stacks leave slivers if many loop points are on a
// line (such as an arc of cuts along one input edge). Flips turn their edges towards the inside.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

/// Whether d is strictly inside the circle through the counter-clockwise a, b, c. Exact for coordinates that
/// differ by less than 2^26.
bool in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d);

/// Flips inner edges of `triangles` (each inner edge is used once in each direction, each boundary edge once)
/// until each is locally Delaunay, decided exactly, or until there were kFlipsPerTriangle flips per triangle
/// (a limit that keeps the cost linear). Flips only strictly convex quadrilaterals, so no triangle is turned
/// over that was not before. The boundary edges and the number of triangles do not change. Throws
/// Interrupted.
inline constexpr std::size_t kFlipsPerTriangle = 8;
void flip_to_delaunay(std::span<const LatticePoint> points, std::span<std::array<std::uint32_t, 3>> triangles,
                      const Execution& execution = kUninterrupted);

}  // namespace fracture
