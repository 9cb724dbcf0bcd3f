// What of a solid one cell of a diagram meets: a few of its triangles instead of all of them, for diagrams of
// which only one cell is wanted (dual = barycenter has one for each fragment).
//
// Inside the cell the patch is the solid: every triangle that meets the cell is there, in the order of the
// whole, so that everything that is exact comes out as it does from the whole, to the bit. Beyond the cell it
// is not closed, and nothing there may be asked for: the clipper is told that no other cell is of interest
// (clip/surface_cuts.hpp). What triangles far away decide, which side of the surface is inside, is said for
// one Voronoi vertex of the cell (clip/winding.hpp goes on from there): counted are the triangles that cross
// the Voronoi edges on a way from it to beyond the box, by the predicates that decide all crossings.
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
  std::vector<TetId> seed;                ///< a Voronoi vertex of the cell, where one is needed ...
  std::vector<InnerVertex> seed_winding;  ///< ... and what winds around it; `tet` is an index into `seed`
  std::uint64_t looked_at = 0;  ///< triangles that were asked whether they cross, or are in the patch

  /// The cell meets nothing of the solid.
  bool empty() const { return surface.parts.empty(); }
};

class PatchFinder {
 public:
  /// A tree of the triangles: n log n. Throws Interrupted.
  PatchFinder(const Solid& solid, const Execution& execution);

  /// The diagram is one of this solid itself (no map), made for its box. Throws Interrupted.
  CellPatch around(const VoronoiDiagram& diagram, SiteId cell, const Execution& execution) const;

 private:
  const Solid& solid_;
  BoxTree tree_;
};

}  // namespace fracture
