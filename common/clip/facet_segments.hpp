// The boundaries of the caps: what the cells' polygons on the surface and the winding inside leave on each bisector.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/surface_cuts.hpp"
#include "common/clip/winding.hpp"
#include "common/solid/solid.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

/// The boundary pieces of all facets, by facet: a facet is (lo, hi, part).
struct FacetSegments {
  std::vector<CapSegment> all;
  std::vector<std::uint32_t> begin;  ///< per facet, and the end of the last one
};

/// Ascending by facet; within one in the order of the surface's polygons, then of the winding's segments. `wanted`: of sites;
/// where given, only facets of which one is wanted. Throws Interrupted, also beyond 2^32 segments (kTooComplex).
FacetSegments gather_segments(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                              const Winding& winding, const Execution& execution,
                              const std::vector<char>* wanted);

}  // namespace fracture
