// Points nearer to one another than a tolerance.
#pragma once

#include <vector>

#include "common/base/disjoint_sets.hpp"
#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Unites all pairs of `members` (distinct positions) whose distance, computed in double, is at most
/// `tolerance` > 0.
///
/// Points are sorted into cells so small that the points of one cell are all near one another; of two cells
/// that are not yet in one set it is enough to know whether they have a near pair, which two k-d trees tell
/// (dual-tree search: Gray & Moore 2001). So the cost is n log n also where very many points lie within one
/// tolerance; only sets of points that lie almost exactly one tolerance from one another, thousands from
/// thousands, cost more.
void unite_near(const std::vector<Vec3f>& positions, const std::vector<VertexId>& members, double tolerance,
                DisjointSets& sets, const Execution& execution);

}  // namespace fracture::solid_detail
