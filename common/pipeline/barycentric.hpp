// dual = barycenter: the source paper's own mode, clipped to the solid.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

struct BarycentricResult {
  FragmentSet set;                  ///< every fragment closed; together no partition of the solid; no bonds
  std::uint32_t skipped_hulls = 0;  ///< cells whose hull was flat
};

/// Cuts the solid by each barycentric cell on its own: cost is sites x triangles, as in the paper (the
/// Voronoi mode has no such term).
BarycentricResult fracture_barycentric(const Solid& solid, const VoronoiDiagram& diagram, Pivot pivot,
                                       const Execution& execution);

}  // namespace fracture
