// Closes holes: covers every loop of open edges with triangles that use its own vertices.
#pragma once

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Returns the open half-edge that follows the open half-edge h on a walk along the hole, that is, against the direction of h.
HalfEdge next_along_hole(const Surface& surface, HalfEdge h, Pacer& pacer);

/// Closes seams first: open edges along one line, within the tolerance (metres), are filled with triangles of
/// almost no area (seams.hpp). Then traces the loops of open half-edges, turning around open fans, and fills
/// each loop. A loop that returns to a vertex is divided there into simple loops. Two opposite open edges are
/// glued together. Longer loops are triangulated and glued in. The new triangles are appended with source
/// kNoIndex. Afterwards, no half-edge is open, but vertices may still have several fans. Returns the first
/// triangle of each fill.
std::vector<TriangleId> fill_holes(Surface& surface, double tolerance, const Execution& execution);

}  // namespace fracture::solid_detail
