// Caps: the interior faces, solid ∩ Voronoi facet. On each facet, the segments of the surface and the
// intervals of Voronoi edges inside the solid, with multiplicity, are chained by key into closed loops. Each
// facet is triangulated once, and both cells get the same triangles, one of them mirrored. By construction,
// the result is closed for any closed surface, even one that crosses itself.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/clip/positions.hpp"
#include "common/clip/surface_cuts.hpp"
#include "common/clip/winding.hpp"

namespace fracture {

/// A connected region of solid ∩ facet(lo, hi): a loop with its holes.
struct CapRegion {
  SiteId lo, hi;       ///< lo < hi
  std::uint32_t part;  ///< index of the solid's part
  std::uint32_t first_triangle, triangle_count;
};

struct Caps {
  std::vector<CapRegion> regions;  ///< by (lo, hi, part)
  /// As seen from cell hi: outward for lo; cell hi uses them mirrored
  std::vector<std::array<CutVertexId, 3>> triangles;
  std::uint64_t crossing = 0;  ///< loops that could not be nested (0 for an embedded surface)
  /// For rough caps (rough/roughen.hpp): the unit normal of each triangle corner, outward for lo. Empty if
  /// the caps are flat.
  std::vector<Vec3f> normals{};
};

/// `wanted` (per site; null: all): builds only the facets of these cells. `winding` and `cuts` must then
/// cover only these cells.
Caps build_caps(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                const Winding& winding, const VertexPositions& positions, const Execution& execution,
                const std::vector<char>* wanted = nullptr);

/// Rotates triangles whose corners share positions, so that they begin at one of these corners. Lattices of
/// sites produce facets without area with such triangles. Two rotations of such a triangle look alike, so its
/// mirror image could be mistaken for an equal triangle. After the rotation, a triangle and its image differ,
/// as they do if all corners are different. build_caps() calls this; call it again after changing triangles
/// or positions.
void begin_at_coinciding_corners(const VertexPositions& positions, Caps& caps, const Execution& execution);

}  // namespace fracture
