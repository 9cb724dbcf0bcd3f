// One ring of points into triangles: balanced splitting where it is convex, ears where it is not.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

/// True when the ring turns left (or not) at every point, at least once, and winds once.
bool is_convex(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring);

/// Steps of the search for ears that a ring of so many points may take. Simple rings take a few for each
/// point, or where the grid does not help half as many as the ring has points.
inline std::size_t ear_patience(std::size_t points) { return (std::size_t{1} << 19) + 64 * points; }

/// Appends ring.size() - 2 triangles that use every edge of the ring exactly once (fewer where the ring
/// passes a point twice and an ear would use one edge both ways). `ring` holds indices into `points`. Where
/// no proper ear exists (the ring touches or crosses itself after rounding) the ear of least |area| is cut:
/// still closed. O(n) for convex rings. Others look at all points of the ring for what blocks an ear, large
/// ones in a grid; the steps of that are taken from `patience`, and when it is used up what is left is halved
/// again and again instead, so that rings that cross themselves everywhere cost no more than others; the
/// answer is false then. Throws Interrupted.
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
