// Caps: the interior faces, solid ∩ Voronoi facet. On each facet the surface's segments and the intervals of
// Voronoi edges inside the solid, with multiplicity, chain by key into closed loops; each facet is
// triangulated once, and both cells get the same triangles, one set mirrored. Closed by algebra for any
// closed surface, self-crossing ones too.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/clip/positions.hpp"
#include "common/clip/surface_cuts.hpp"
#include "common/clip/winding.hpp"

namespace fracture {

/// A connected piece of solid ∩ facet(lo, hi): a loop with its holes.
struct CapRegion {
  SiteId lo, hi;       ///< lo < hi
  std::uint32_t part;  ///< of the solid
  std::uint32_t first_triangle, triangle_count;
};

struct Caps {
  std::vector<CapRegion> regions;  ///< by (lo, hi, part)
  std::vector<std::array<CutVertexId, 3>>
      triangles;               ///< as seen from cell hi: outward for lo; cell hi takes them mirrored
  std::uint64_t crossing = 0;  ///< loops that could not be nested (0 on embedded input)
  /// Of rough caps (rough/roughen.hpp): per corner of each triangle the unit normal, outward for lo; empty:
  /// flat.
  std::vector<Vec3f> normals{};
};

/// `wanted` (per site; null: all): only the facets of these cells, where winding and cuts are theirs
/// alone.
Caps build_caps(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                const Winding& winding, const VertexPositions& positions, const Execution& execution,
                const std::vector<char>* wanted = nullptr);

/// Lattices of sites make facets without area, and these triangles whose corners share places. Two turns of
/// such a triangle look alike, so that its mirror image could be taken for its like; begun at one of the
/// corners that share a place, it and its image differ as they do where all corners do. Done in build_caps();
/// again after triangles or places were changed.
void begin_at_coinciding_corners(const VertexPositions& positions, Caps& caps, const Execution& execution);

}  // namespace fracture
