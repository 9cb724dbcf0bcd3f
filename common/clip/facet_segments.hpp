// The boundaries of the caps on each bisector: sides of the cells' polygons on the surface, and pieces of
// Voronoi edges inside.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/surface_cuts.hpp"
#include "common/clip/winding.hpp"
#include "common/solid/solid.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

/// The boundary pieces of all facets, grouped by facet. A facet is (lo, hi, part).
struct FacetSegments {
  std::vector<CapSegment> all;
  std::vector<std::uint32_t> begin;  ///< index of each facet's first segment, and the end of the last facet
};

/// Gathers the segments in ascending order of facets; within a facet, first those of the surface's polygons,
/// then those of the winding. `wanted`: per site; if given, only facets with a wanted site are included.
/// Throws Interrupted, with kTooComplex beyond 2^32 segments.
FacetSegments gather_segments(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                              const Winding& winding, const Execution& execution,
                              const std::vector<char>* wanted);

}  // namespace fracture
