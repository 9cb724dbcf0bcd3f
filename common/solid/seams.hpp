// Seams at which two sides of a surface meet along one line, but with different vertices: a face that was subdivided and
// its neighbour that was not ("T-junctions").
//
//        u ------------- v     the long side is one half-edge, from u to v,
//        u <-- m1 <-- m2 <-- v     the other has vertices between them
//
// Neither side has an open edge in common with the other, so that each would be closed by itself: the subdivided face
// would be a sheet without volume, and interior material would take its place.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Loops of open half-edges, as fill_holes() walks them (against the half-edges: each begins where the next one ends). All
/// vertices of a loop are within `tolerance` (metres; 0: exactly, in doubles) of the segment between two of its vertices,
/// along which its two sides run from end to end. It begins at a vertex at which several loops of open edges meet. Loops
/// have no half-edge in common. n log n in the open half-edges: where so many lines overlap that it would be more, the
/// search ends early and finds fewer.
std::vector<std::vector<HalfEdge>> find_seams(const Surface& surface, double tolerance,
                                              const Execution& execution);

}  // namespace fracture::solid_detail
