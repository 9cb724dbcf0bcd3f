// The inner side of a wall: a closed surface inside a solid, everywhere at least so far from its own surface.
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
  /// Counter-clockwise seen from the hollow: seen from outside of the wall.
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

struct InnerSurfaceLimits {
  std::uint32_t triangles = 20'000;
  std::uint32_t marched =
      20'000;  ///< as many as the lattice may make, before those that nobody would miss go
  std::uint32_t lattice_points = 1u << 18;
};

/// Empty where no place inside is deep enough for it. `surface`: that of the part, closed; `box`: its box.
///
/// Marching tetrahedra (Doi & Koide 1991) over the six tetrahedra of each cube of a lattice (Freudenthal 1942), of
/// the places that are inside and deep enough. Closed, and without self-crossing: corners lie on edges of the
/// lattice, at sixteenths of them, which floats hold exactly, and each tetrahedron has its own piece.
///
/// Nothing between the corners v of a triangle is nearer to the outside than `thickness` t: for its point x, the
/// mean of the v weighted by w, and any y, sum w |v - y|^2 = |x - y|^2 + sum w |v - x|^2, whose last sum is at most
/// h^2, h the step of the lattice; so it is enough that corners are sqrt(t^2 + h^2) deep. h is at most half of t
/// unless the limits want it larger, and then the wall is thicker than was asked.
///
/// The triangles of a lattice are as many where the surface is flat as where it bends: it is simplified (simplify.hpp) by
/// at most an eighth of a step, and looked at again; where it then came too near to the outside, or crossed itself, it is
/// simplified less or stays as it was.
///
/// `other`, where asked for, becomes the least that would have to be allowed for another surface: with limits that are
/// no less than those given, and both below `other`, the same comes. Throws Interrupted.
InnerSurface inner_surface(const SurfaceTree& surface, const Box& box, double thickness,
                           const InnerSurfaceLimits& limits, const Execution& execution,
                           InnerSurfaceLimits* other = nullptr);

}  // namespace fracture::hollow_detail
