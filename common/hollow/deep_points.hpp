// Finds the points of a lattice that are deep inside a closed surface.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/hollow/lattice.hpp"

namespace fracture::hollow_detail {

/// Per point: 1 if it is inside, no triangle is nearer than `depth`, and its connected group has at least
/// `smallest` points. `depth` must be at least half the diagonal of a cube of the lattice. A point is inside
/// if the triangles wind around it: van Oosterom & Strackee 1983, "The Solid Angle of a Plane Triangle".
/// Throws Interrupted.
std::vector<std::uint8_t> deep_points(const SurfaceTree& surface, const Lattice& lattice, double depth,
                                      std::uint32_t smallest, const Execution& execution);

/// Whether a ball of this radius, m, fits inside the surface. Cubes that may contain its middle are halved
/// down to a sixteenth of the radius. So a ball 1.06 times as large is always found, and a smaller ball is
/// never accepted. The radius must be at least a twentieth of the longest side of the box. Throws
/// Interrupted.
bool holds_ball(const SurfaceTree& surface, const Box& box, double radius, const Execution& execution);

}  // namespace fracture::hollow_detail
