// Finds the number of cells needed for a number of fragments. For patterns that divide the box of a solid
// (grids, bricks, slices, rings and spokes), it is unknown how many of their cells the solid fills. For
// patterns that crowd cells together, some cells are too small to keep.
#pragma once

#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/solid/image.hpp"

namespace fracture {

/// Calls plan_sites(). If as many cells as fragments are requested, it asks for more cells. For impacts and
/// clusters, some of whose cells are too small to keep, it asks for twice as many. For a pattern that
/// divides the box, it repeats the plan a few times, until enough of the cells contain one of a set of
/// sample points in the solid. With a kept region, which is one fragment, it asks for as many more as the
/// region takes away. It does not repeat for more than about 700 fragments, or for cells of a
/// given size. Returns the errors of plan_sites() for any of these plans, because the sites must not depend
/// on the server. Throws Interrupted.
Expected<SitePlan> plan_enough_sites(const SeenSolid& solid, const FractureParameters& parameters,
                                     const Execution& execution);

/// Approximate number of sites that plan_enough_sites() asks for, to estimate the cost of a request before
/// it is computed.
double sites_for_fragments(const FractureParameters& parameters);

}  // namespace fracture
