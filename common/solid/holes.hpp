// Closing holes: every loop of open edges is covered by triangles over its own vertices.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Traces the loops of open half-edges (each turns around open fans, so after split_umbrellas() it visits a
/// vertex once) and fills each: two opposite open edges are glued to one another, longer loops are
/// triangulated and glued in. Filled triangles are appended with source kNoIndex. Afterwards no half-edge is
/// open. Returns the first triangle of each fill.
std::vector<TriangleId> fill_holes(Surface& surface, const Execution& execution);

}  // namespace fracture::solid_detail
