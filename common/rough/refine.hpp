// Caps as meshes of even triangles. Where a cap is wide enough it gets a core, equilateral triangles of a
// lattice in its plane; a collar joins the core to the cap's own loops. The loops keep their vertices and get
// those of EdgeSplits; what a cap shares with the outer surface is not divided.
//
//      +--------------+
//      | collar       |        core: lattice triangles all of whose corners are at least kMargin lengths
//      |   /\/\/\/\   |              from every edge of the loops
//      |   \/\/\/\/   |        collar: between the loops and the rim of the core, triangulated as caps are
//      +--------------+
#pragma once

#include <functional>

#include "common/base/execution.hpp"
#include "common/clip/caps.hpp"

namespace fracture {

/// Which caps (lo, hi) are refined, and which of the others the file will show: their outlines stay as they
/// are, so that what refined caps share with them is not divided either.
struct RefinedCaps {
  std::function<bool(SiteId, SiteId)> wanted, plain;
};

/// Replaces the triangles of the wanted caps and appends the new vertices to `positions`,
/// in the planes of the facets. `length` (> 0, m): of the edges. The regions stay in their order; one whose
/// loops cross may become several. Which ids the new vertices get does not depend on the number of threads.
void refine_caps(const VoronoiDiagram& diagram, const Winding& winding, double length,
                 const RefinedCaps& which, Caps& caps, VertexPositions& positions,
                 const Execution& execution);

}  // namespace fracture
