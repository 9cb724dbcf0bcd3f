// Lloyd's relaxation (Lloyd 1982; Du, Faber & Gunzburger 1999, "Centroidal Voronoi tessellations"): pieces of
// more even size and rounder shape. Exact in that the cells are those that fracture() would cut, solid and
// all: each pass moves every site to the centre of mass of solid ∩ cell.
#pragma once

#include "common/sites/pattern.hpp"

namespace fracture {

/// `passes` times; the sites stay on the site lattice. Sites whose cell misses the solid stay where they are.
/// `solid` is seen through plan.map. The plan must have no groups. Errors of
/// tetrahedralize(); throws Interrupted.
Expected<void> relax(const SeenSolid& solid, SitePlan& plan, std::uint32_t passes,
                     const Execution& execution);

}  // namespace fracture
