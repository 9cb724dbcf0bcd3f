// Triangulates one ring of points: balanced splitting if it is convex, otherwise ears.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

/// Whether the ring turns left or goes straight at every point, turns left at least once, and winds once.
bool is_convex(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring);

/// Maximum number of steps in the search for ears of a ring. Simple rings take a few steps per point or, if
/// the grid does not help, half as many per point as the ring has points.
inline std::size_t ear_patience(std::size_t points) { return (std::size_t{1} << 19) + 64 * points; }

/// Appends ring.size() - 2 triangles that use every edge of the ring exactly once. (Fewer if the ring passes
/// a point twice and an ear would use one edge in both directions.) `ring` contains indices into `points`. If
/// there is no proper ear (because the ring touches or crosses itself after rounding), cuts the ear with the
/// least |area|; the result is still closed.
///
/// O(n) for convex rings. Other rings search all their points, large rings in a grid, for points that block
/// an ear. These steps are subtracted from `patience`. When it is used up, the rest is halved recursively
/// instead, so rings that cross themselves everywhere cost no more than others. The result is then false.
/// Throws Interrupted.
bool clip_ears(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
               std::vector<std::array<std::uint32_t, 3>>& triangles, const Execution& execution,
               std::size_t& patience);
inline bool clip_ears(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                      std::vector<std::array<std::uint32_t, 3>>& triangles,
                      const Execution& execution = kUninterrupted) {
  std::size_t patience = ear_patience(ring.size());
  return clip_ears(points, ring, triangles, execution, patience);
}

}  // namespace fracture
