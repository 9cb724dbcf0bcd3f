// Few convex hulls for fragments of many cells. One for each cell would multiply the physics; one around several cells
// reaches into those of other fragments. So neighbouring cells share a hull, cut back until it lies within the cells of
// its fragment:
//
// Let A be some cells of a fragment F, and j the site of a cell that shares a facet with one of F's. Each bisector of j
// and a site i of A has all of cell j behind it. A convex body that begins in A and is cut by one such bisector for each
// j meets none of these cells; it hangs together, and who leaves the cells of F goes through one of them. So it lies
// within them, and hulls of different fragments cannot overlap. Of the bisectors that do, the one is taken that cuts
// least away; those of A's largest cell always do, and keep all of that.
//
// All that this hangs on is F's cells and their neighbours: a hit elsewhere does not change it.
#pragma once

#include <cstdint>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

/// Hulls of the fragments of `set` that have more bodies than `most` (> 0), at most so many of each; of the others none
/// (make_collision_hulls() makes them). `has_rest`: a fragment of very many cells is a rest that stays whole, and has one
/// for each `cells` of them; none is made if `cells` is 1. `diagram`: whose cells the bodies are shares of. Throws Interrupted.
CollisionHulls make_aggregate_hulls(const FragmentSet& set, const VoronoiDiagram& diagram, std::uint32_t most,
                                    std::uint32_t cells, bool has_rest, const Execution& execution);

}  // namespace fracture
