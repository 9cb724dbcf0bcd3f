// Where the Voronoi sites go.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The cubic power-of-two lattice that generated sites are snapped to, the same step on all axes: the box is
/// at most 2^21 steps wide, and its coordinates (multiples of step) are exact doubles.
struct SiteLattice {
  double step = 1;
  Vec3d snap(const Vec3d& p) const;  ///< nearest lattice point, ties to even
};
SiteLattice site_lattice(const Box& box);

/// `count` points uniform in the volume of the solid, snapped to site_lattice(solid.box); deterministic in
/// the seed and in the geometry, and independent of thread count. A prefix of a longer sequence: the first n
/// of sites(m) are sites(n). Sites may coincide (the tetrahedralization merges and reports duplicates).
/// Near-linear in triangles + count.
Expected<std::vector<Vec3d>> uniform_sites(const Solid& solid, std::uint32_t count, std::uint64_t seed,
                                           const Execution& execution);

}  // namespace fracture
