// Points that are nearer to each other than a tolerance.
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
/// Points are sorted into cells so small that all points of a cell are near one another. For two cells that
/// are not yet in one set, it is enough to know whether they have a near pair, which two k-d trees find
/// (dual-tree search: Gray & Moore 2001). So the cost is n log n even if very many points are within one
/// tolerance. Only sets of thousands of points that are almost exactly one tolerance apart cost more.
void unite_near(const std::vector<Vec3f>& positions, const std::vector<VertexId>& members, double tolerance,
                DisjointSets& sets, const Execution& execution);

}  // namespace fracture::solid_detail
