// The inner side of a wall: a closed surface inside a solid, at a minimum distance from the solid's surface
// everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/bvh/surface_tree.hpp"

namespace fracture::hollow_detail {

struct InnerSurface {
  std::vector<Vec3f> positions;
  /// Counter-clockwise seen from the cavity, that is, from outside the wall.
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

struct InnerSurfaceLimits {
  std::uint32_t triangles = 20'000;
  std::uint32_t marched = 20'000;  ///< maximum number from the lattice, before simplification
  std::uint32_t lattice_points = 1u << 18;
};

/// Computes the inner surface. It is empty if no point inside is deep enough. `surface`: the closed surface
/// of the part; `box`: its box.
///
/// Uses marching tetrahedra (Doi & Koide 1991) over the six tetrahedra of each cube of a lattice (Freudenthal
/// 1942), on the points that are inside and deep enough. The surface is closed and does not cross itself:
/// corners are on lattice edges, at multiples of a sixteenth, which floats represent exactly, and each
/// tetrahedron contains its own polygon.
///
/// No point between the corners v of a triangle is nearer to the outside than `thickness` t. For a point x of
/// the triangle, the mean of the v weighted by w, and any point y, sum w |v - y|^2 = |x - y|^2 + sum w |v -
/// x|^2. The last sum is at most h^2, where h is the step of the lattice. So it is sufficient that corners
/// are sqrt(t^2 + h^2) deep. h is at most t / 2, unless the limits require a larger step; then the wall is
/// thicker than requested.
///
/// The lattice gives as many triangles in flat regions as in curved ones. So the surface is simplified
/// (simplify.hpp) by at most an eighth of a step, and checked again. If it then comes too near to the outside
/// or crosses itself, it is simplified less, or not at all.
///
/// `other`, if not null, receives the smallest limits that would give another surface. Any limits that are
/// not less than the given ones and below `other` give the same surface. Throws Interrupted.
InnerSurface inner_surface(const SurfaceTree& surface, const Box& box, double thickness,
                           const InnerSurfaceLimits& limits, const Execution& execution,
                           InnerSurfaceLimits* other = nullptr);

}  // namespace fracture::hollow_detail
