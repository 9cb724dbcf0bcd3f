// How many cells it takes for a number of fragments. Patterns that divide the box of a solid (grids, bricks,
// slices, rings and spokes) do not know how many of their cells the solid fills; some cells of those that crowd
// them together are too small to stay.
#pragma once

#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/solid/image.hpp"

namespace fracture {

/// plan_sites(). Where a number of fragments is wanted, for more cells: of impacts and clusters, where small
/// fragments are united, for twice as many; of a pattern that divides the box until so many of its cells
/// hold one of the points that are drawn in the solid, asked a few times. A pattern whose cells have a given size makes no more. Errors of plan_sites(); where a further plan would need too many sites, the one before it is taken.
/// Throws Interrupted.
Expected<SitePlan> plan_enough_sites(const SeenSolid& solid, const FractureParameters& parameters,
                                     const Execution& execution);

}  // namespace fracture
