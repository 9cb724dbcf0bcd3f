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
  std::uint32_t dropped = 0;        ///< fragments above `drop_above`
  double dropped_volume = 0;        ///< m³, of those
  /// Triangles that were looked at, once for each cell that they were near to: what the work grows with.
  std::uint64_t looked_at = 0;
};

/// Cuts the solid by each barycentric cell on its own, of which each meets a patch of the solid
/// (cell_patch.hpp): near-linear in the triangles and in what comes out, where the paper's cost is
/// sites x triangles. `drop_above`, m³: larger fragments are left out, the paper's volume filter
/// (section 5 there: pieces that look too large); 0: none.
BarycentricResult fracture_barycentric(const Solid& solid, const VoronoiDiagram& diagram, Pivot pivot,
                                       double drop_above, const Execution& execution);

}  // namespace fracture
