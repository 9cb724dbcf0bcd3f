// Positions of the Voronoi sites.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The cubic lattice that generated sites are snapped to. Its step is a power of two, the same on all axes.
/// The box is at most 2^21 steps wide, and its coordinates (multiples of the step) are exact doubles.
struct SiteLattice {
  double step = 1;
  Vec3d snap(const Vec3d& p) const;  ///< nearest lattice point, ties to even
};
SiteLattice site_lattice(const Box& box);

/// Returns `count` points, uniform in the volume of the solid and snapped to site_lattice(solid.box).
/// Deterministic in the seed and the geometry, and independent of the thread count. The first n of a longer
/// sequence are the points for count = n. Sites may coincide (the tetrahedralization merges and reports
/// duplicates). Near-linear in triangles + count.
Expected<std::vector<Vec3d>> uniform_sites(const Solid& solid, std::uint32_t count, std::uint64_t seed,
                                           const Execution& execution);

}  // namespace fracture
