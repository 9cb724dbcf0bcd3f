// Seams at which two sides of a surface meet along one line, but with different vertices: a face that was subdivided and
// its neighbour that was not ("T-junctions").
//
//        u ------------- v     the long side is one half-edge, from u to v,
//        u <-- m1 <-- m2 <-- v     the other has vertices between them
//
// The two sides have no open edge in common, so each would be closed separately. Then the subdivided face
// would be a sheet without volume, and interior material would take its place.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Returns loops of open half-edges, in the order in which fill_holes() walks them (against the half-edges:
/// each begins where the next one ends). All vertices of a loop are within `tolerance` (metres; 0: exactly,
/// in doubles) of the segment between two of its vertices. Its two sides both connect these two vertices. A
/// loop begins at a vertex where several loops of open edges meet. Loops share no half-edge. n log n in the
/// open half-edges; if so many lines overlap that it would take longer, the search ends early and finds fewer
/// loops.
std::vector<std::vector<HalfEdge>> find_seams(const Surface& surface, double tolerance,
                                              const Execution& execution);

/// Merges the ends of seams between different holes, so that find_seams() finds these seams. Two ends merge if they are different
/// vertices at most `tolerance` (metres) apart; a chain of such ends becomes one vertex. The vertex with the lowest id keeps its
/// position. weld_tolerant() cannot merge them, because it compares whole edges, and the two sides have different edges. Seams
/// that find_seams() already finds do not change. Vertices of a triangle that would collapse do not merge. `surface` must be
/// glued; it stays glued.
void weld_ends_of_seams(Surface& surface, double tolerance, SolidReport& report, const Execution& execution);

}  // namespace fracture::solid_detail
