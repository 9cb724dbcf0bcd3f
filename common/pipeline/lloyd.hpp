// Lloyd's relaxation (Lloyd 1982; Du, Faber & Gunzburger 1999, "Centroidal Voronoi tessellations"), for
// rounder pieces of more even size. It uses the same cells, clipped to the solid, that fracture() would
// cut: each pass moves every site to the centre of mass of solid ∩ cell.
#pragma once

#include "common/sites/pattern.hpp"

namespace fracture {

/// Relaxes the plan's sites `passes` times; the sites stay on the site lattice. Sites whose cell misses the
/// solid do not move. `solid` is seen through plan.map. The plan must have no groups. Errors: those of
/// tetrahedralize(). Throws Interrupted.
Expected<void> relax(const SeenSolid& solid, SitePlan& plan, std::uint32_t passes,
                     const Execution& execution);

}  // namespace fracture
