// Caps as meshes of even triangles. If a cap is wide enough, it gets a core: equilateral triangles of a
// lattice in its plane. A collar joins the core to the cap's own loops. The loops keep their vertices and get
// those of EdgeSplits. The edges that a cap shares with the outer surface are not divided.
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

/// Selects the caps (lo, hi) to refine (`wanted`), and the other caps that are visible in the file (`plain`).
/// Edges shared with plain caps are not divided, so the outlines of plain caps stay unchanged.
struct RefinedCaps {
  std::function<bool(SiteId, SiteId)> wanted, plain;
};

/// Replaces the triangles of the wanted caps, and appends the new vertices, which are in the planes of the
/// facets, to `positions`. `length` (> 0, m) is the length of the edges. Regions stay in order; a region
/// whose loops cross may become several. The ids of the new vertices do not depend on the number of threads.
void refine_caps(const VoronoiDiagram& diagram, const Winding& winding, double length,
                 const RefinedCaps& which, Caps& caps, VertexPositions& positions,
                 const Execution& execution);

}  // namespace fracture
