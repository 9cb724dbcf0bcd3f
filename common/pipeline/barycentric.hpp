// The mode dual = barycenter: the source paper's own cells, clipped to the solid.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

struct BarycentricResult {
  FragmentSet set;                  ///< closed fragments without bonds; together no partition of the solid
  std::uint32_t skipped_hulls = 0;  ///< cells whose hull was flat
  std::uint32_t dropped = 0;        ///< fragments above `drop_above`
  double dropped_volume = 0;        ///< m³, of the dropped fragments
  /// Number of triangles tested, counted once for each cell that they are near. The work grows with it.
  std::uint64_t looked_at = 0;
};

/// Cuts the solid with each barycentric cell separately. Each cell uses only a patch of the solid
/// (cell_patch.hpp). So the cost is near-linear in the triangles and in the output, whereas the paper's is
/// sites x triangles. `drop_above`, m³: larger fragments are left out, which is the paper's volume filter
/// (section 5: pieces that look too large); 0: none are.
BarycentricResult fracture_barycentric(const Solid& solid, const VoronoiDiagram& diagram, Pivot pivot,
                                       double drop_above, const Execution& execution);

}  // namespace fracture
