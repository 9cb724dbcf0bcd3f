// A few convex hulls for fragments with many cells. One hull per cell would make physics slow. One hull around several
// cells reaches into the cells of other fragments. So neighbouring cells share a hull, which is cut back until it lies
// within the cells of its fragment:
//
// Let A be some cells of a fragment F, and j the site of a cell that shares a facet with one of F's cells. For any site i
// of A, all of cell j is behind the bisector of i and j. Cut a convex body that begins in A by one such bisector for each
// j: it then meets none of these cells. It is connected, and any path out of F's cells goes through such a cell. So it is
// within F's cells, and hulls of different fragments cannot overlap. For each j, the bisector that cuts away least is
// chosen. The bisectors of A's largest cell are always valid, and keep all of that cell.
//
// If these hulls close an opening of the fragment (divided_hulls.hpp), they are replaced by the hulls of its convex parts
// (convex_parts.hpp), which are cut back in the same way. A part begins in the cell that contains its middle.
//
// The result depends only on F's cells and their neighbours, so a hit elsewhere does not change it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

/// Makes at most `limits.count` hulls for each fragment with more bodies than that, or with several bodies whose own hulls
/// close an opening. make_collision_hulls() makes those of the other fragments, of which some may have one per body here already.
/// `has_rest`: a fragment with very many cells is a rest that stays whole. It gets one hull for every `cells` cells, or none
/// here if `cells` is 1, unless it has more than `most_of_rest` bodies; then it gets at most that number
/// of hulls here. `diagram`: the cells that were cut. Throws Interrupted.
CollisionHulls make_aggregate_hulls(const FragmentSet& set, const VoronoiDiagram& diagram,
                                    const HullLimits& limits, std::uint32_t cells, bool has_rest,
                                    const Execution& execution, std::size_t most_of_rest = SIZE_MAX);

}  // namespace fracture
