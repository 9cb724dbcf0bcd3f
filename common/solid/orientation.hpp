// Consistent orientation of edge-connected patches.
#pragma once

#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Within each patch (triangles connected across edges with exactly two uses) flips the minority so that
/// neighbours agree; on a tie the lowest triangle keeps its orientation. A patch that cannot be oriented
/// (Möbius, Klein) keeps edges whose two uses run the same way: they stay open and are closed like holes. The
/// report counts the triangles flipped; the edge table is stale when true is returned.
bool orient_patches(Surface& surface, const EdgeTable& edges, SolidReport& report,
                    const Execution& execution);

}  // namespace fracture::solid_detail
