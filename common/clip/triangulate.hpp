// Triangulates planar loops with holes on an integer lattice. Every loop edge is used exactly once and no
// vertex is added, regardless of how rounding has changed the loops. This guarantee is topological: each step
// joins two rings by a diagonal, divides a ring, or cuts an ear, and none of these can omit an edge. Geometry
// only chooses between these steps, by exact orientation tests (25-bit coordinates, so products fit into a
// 64-bit integer).
//
// Small or convex rings are triangulated by ears (Meisters 1975). All others are divided into monotone rings
// by a plane sweep (Lee & Preparata 1977; de Berg et al., Computational Geometry, ch. 3), which also joins
// holes to their outer ring. Then each monotone ring is triangulated with a stack (Garey et al. 1978): O(n
// log n). If that turns triangles over, it is done again with other methods: rings that return to a position
// are divided (pinched_ring.hpp), small ones get the least area (least_area.hpp), and loops that touch are
// linked and moved apart (touching_loops.hpp).
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

/// Twice the signed area of (a, b, c); positive if counter-clockwise. Exact.
inline std::int64_t orient2d(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

struct Triangulation {
  /// Indices of points, counter-clockwise unless degenerate
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> region;  ///< per triangle: id, from 0, of its region (a ring with its holes)
  std::uint32_t regions = 0;
  /// Number of rings that should be holes (clockwise) but are in no outer ring. Each is a region by itself,
  /// reversed. This happens only if loops cross; it is 0 for every embedded input.
  std::uint32_t unnested_loops = 0;

  /// Clears the contents but keeps the memory.
  void clear() {
    triangles.clear();
    region.clear();
    regions = unnested_loops = 0;
  }
};

/// Triangulates the loops. `loop_begin` has one entry per loop, and a last entry that equals points.size().
/// Outer loops are counter-clockwise, and holes clockwise. A loop has at least 3 points (loops of 2 points,
/// which enclose nothing, are permitted and give no triangle). Replaces the contents of `out`. O(n log n),
/// even for loops that cross themselves and each other everywhere: rings that are not monotone are then
/// triangulated without regard to shape. Throws Interrupted.
void triangulate(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                 Triangulation& out, const Execution& execution = kUninterrupted);

}  // namespace fracture
