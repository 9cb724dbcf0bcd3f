// Which points of a lattice lie deep inside a closed surface.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/hollow/lattice.hpp"

namespace fracture::hollow_detail {

/// Per point: 1 where it is inside and no triangle is nearer than `depth`, in groups of at least `smallest` that
/// hang together. `depth` is at least half the diagonal of a cube of the lattice. Inside is what the triangles wind
/// around: van Oosterom & Strackee 1983, "The Solid Angle of a Plane Triangle". Throws Interrupted.
std::vector<std::uint8_t> deep_points(const SurfaceTree& surface, const Lattice& lattice, double depth,
                                      std::uint32_t smallest, const Execution& execution);

/// Whether a ball of that radius, m, fits inside the surface. Cubes in which its middle may be are halved down to a
/// sixteenth of the radius: a ball that is 1.06 times as large is never missed, and none that is smaller is taken for
/// it. The radius is at least a twentieth of the longest side of the box. Throws Interrupted.
bool holds_ball(const SurfaceTree& surface, const Box& box, double radius, const Execution& execution);

}  // namespace fracture::hollow_detail
