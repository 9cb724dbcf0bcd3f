// Gives patches of edge-connected triangles a consistent orientation.
#pragma once

#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// In each patch (triangles connected across edges with exactly two uses), flips the minority so that
/// neighbours agree. On a tie, the lowest triangle keeps its orientation. A patch that cannot be oriented
/// (Möbius, Klein) keeps edges whose two uses have the same direction. These stay open and are closed like
/// holes. The report counts the flipped triangles. If the result is true, the edge table is out of date.
bool orient_patches(Surface& surface, const EdgeTable& edges, SolidReport& report,
                    const Execution& execution);

}  // namespace fracture::solid_detail
