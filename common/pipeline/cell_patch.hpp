// The patch of a solid that one cell of a diagram meets: a few triangles instead of all, for diagrams of
// which only one cell is needed (dual = barycenter makes one per fragment).
//
// Inside the cell, the patch equals the solid: it has every triangle that meets the cell, in the order of
// the whole. So all exact results are the same as with the whole, to the bit. Beyond the cell, the patch is
// not closed and must not be queried, so the clipper is told that no other cell is of interest
// (clip/surface_cuts.hpp). Which side of the surface is inside depends on triangles far away. It is
// therefore computed for one Voronoi vertex of the cell, from which clip/winding.hpp continues. The
// computation follows Voronoi edges from this vertex to beyond the box, and counts the triangles that cross
// them. The predicates are those that decide all crossings.
#pragma once

#include <cstdint>
#include <vector>

#include "common/bvh/box_tree.hpp"
#include "common/clip/winding.hpp"
#include "common/solid/patch.hpp"
#include "common/solid/solid.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

struct CellPatch {
  SolidPatch surface;
  std::vector<TetId> seed;                ///< a Voronoi vertex of the cell, if one is needed ...
  std::vector<InnerVertex> seed_winding;  ///< ... and its windings; `tet` is an index into `seed`
  std::uint64_t looked_at = 0;            ///< triangles that were tested for crossings or are in the patch

  /// Whether the cell does not meet the solid.
  bool empty() const { return surface.parts.empty(); }
};

class PatchFinder {
 public:
  /// Builds a tree of the triangles in n log n. Throws Interrupted.
  PatchFinder(const Solid& solid, const Execution& execution);

  /// Returns the patch for a cell. The diagram must be of this solid itself (no map) and made for its box.
  /// Throws Interrupted.
  CellPatch around(const VoronoiDiagram& diagram, SiteId cell, const Execution& execution) const;

 private:
  const Solid& solid_;
  BoxTree tree_;
};

}  // namespace fracture
