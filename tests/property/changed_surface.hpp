// Measures what a hit changed on the surface of an answer. The fragments must have the pivot of the source (Pivot::kSource), so that
// positions are those of the mesh.
#pragma once

#include <cstdint>

#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// The largest distance from `from` of a vertex that is not at the place of one before. 0 if all are. `outside`: only vertices of the
/// outer surface.
double farthest_new_vertex(const FragmentSet& before, const FragmentSet& after, const Vec3d& from,
                           bool outside);

struct ChangedSurface {
  double farthest = 0;        ///< m: distance from the hit of the farthest point with another fragment
  std::size_t points = 0;     ///< points that were compared
  std::size_t changed = 0;    ///< those with another fragment
  std::size_t uncovered = 0;  ///< those on no fragment of one of the answers
};

/// Draws `count` points in each triangle of the mesh, and compares the ids of the fragments that they are on. `traced`: made by
/// with_traced_triangles(); both answers are of it.
ChangedSurface changed_surface(const FragmentSet& before, const FragmentSet& after, const Mesh& traced,
                               const Vec3d& from, int count, std::uint64_t seed);

}  // namespace fracture::test
