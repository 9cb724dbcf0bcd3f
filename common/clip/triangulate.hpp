// Triangulation of planar loops with holes on an integer lattice: every loop edge is used exactly once, no
// vertex is added, whatever the rounding has done to the loops. That promise is topological: each step either
// joins two rings by a diagonal, splits one, or cuts an ear, and none of these can fail to use an edge.
// Geometry only chooses among them, by exact orientation tests (25-bit coordinates: products fit a 64-bit
// integer).
//
// Small or convex rings: ears (Meisters 1975). Everything else: monotone partition by a plane sweep (Lee &
// Preparata 1977; de Berg et al., Computational Geometry, ch. 3), which also joins holes to their outer ring,
// then a stack for each monotone piece (Garey et al. 1978): O(n log n). Where that turns triangles over, once
// more: rings that come back to a place divided (pinched_ring.hpp), small ones with the least area
// (least_area.hpp), and loops that touch linked and moved apart (touching_loops.hpp).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"

namespace fracture {

struct LatticePoint {
  std::int64_t x = 0, y = 0;  ///< |coordinate| < 2^30
  friend bool operator==(const LatticePoint&, const LatticePoint&) = default;
};

/// Twice the signed area of (a, b, c); positive when counter-clockwise. Exact.
inline std::int64_t orient2d(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

struct Triangulation {
  std::vector<std::array<std::uint32_t, 3>>
      triangles;                      ///< indices of points, counter-clockwise where not degenerate
  std::vector<std::uint32_t> region;  ///< per triangle: ids 0.. of connected regions (a ring with its holes)
  std::uint32_t regions = 0;
  /// Rings that should be holes (clockwise) but lie in no outer ring: their region is themselves, reversed.
  /// Happens only when loops cross; 0 for every embedded input.
  std::uint32_t unnested_loops = 0;

  /// Keeps the memory.
  void clear() {
    triangles.clear();
    region.clear();
    regions = unnested_loops = 0;
  }
};

/// `loop_begin` has one entry per loop and a last one = points.size(). Outer loops run counter-clockwise,
/// holes clockwise; a loop has at least 3 points (2-point loops, which enclose nothing, are allowed and give
/// no triangle). Replaces the contents of `out`. n log n, also for loops that cross themselves and each other
/// everywhere: what is no monotone ring then is given triangles without regard to their shape. Throws
/// Interrupted.
void triangulate(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                 Triangulation& out, const Execution& execution = kUninterrupted);

}  // namespace fracture
