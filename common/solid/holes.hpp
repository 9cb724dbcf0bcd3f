// Closing holes: every loop of open edges is covered by triangles over its own vertices.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Closes seams first: what lies along them within the tolerance (metres) is filled with triangles that hardly have an
/// area (seams.hpp). Then traces the loops of open half-edges, turning around open fans, and fills each: a loop that
/// comes back to a vertex is taken apart there into simple loops; two opposite open edges are glued to one another;
/// longer loops are triangulated and glued in. Filled triangles are appended with source kNoIndex. Afterwards no
/// half-edge is open; vertices may still have several fans. Returns the first triangle of each fill.
std::vector<TriangleId> fill_holes(Surface& surface, double tolerance, const Execution& execution);

}  // namespace fracture::solid_detail
