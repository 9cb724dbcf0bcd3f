// How many cells it takes for a number of fragments. Patterns that divide the box of a solid (grids, bricks,
// slices, rings and spokes) do not know how many of their cells the solid fills; some cells of those that crowd
// them together are too small to stay.
#pragma once

#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/solid/image.hpp"

namespace fracture {

/// plan_sites(). Where as many cells as fragments are asked for, for more cells: of impacts and clusters, of
/// which some are too small to stay, for twice as many; of a pattern that divides the box until so many of its
/// cells hold one of the points that are drawn in the solid, asked a few times (not for more than some 700
/// fragments, nor of cells of a given size). Errors of plan_sites(), for any of these plans: which sites there
/// are is no matter of the server. Throws Interrupted.
Expected<SitePlan> plan_enough_sites(const SeenSolid& solid, const FractureParameters& parameters,
                                     const Execution& execution);

/// About how many it asks for, for those who have to know what a request costs before it is computed.
double sites_for_fragments(const FractureParameters& parameters);

}  // namespace fracture
