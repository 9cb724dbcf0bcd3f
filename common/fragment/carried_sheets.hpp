// Cuts sheets by the diagram that cuts the solid, and gives each piece to a fragment. A sheet bounds no volume, so
// its pieces are not part of the partition: they are open surfaces that move with a fragment.
//
// Every triangle is divided among the cells as the solid's own triangles are (clip/surface_cuts.hpp): exactly, with
// the same names for the points at cuts on both sides. The cuts are those of the flat cells, also if the solid's
// are rough.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

/// Returns, per triangle of the sheets' surface, the part of the solid that is nearest to the first triangle of its connected
/// sheet. n log n. Throws Interrupted.
std::vector<std::uint32_t> parts_near_sheets(const Solid& solid, const Solid& surface,
                                             const Execution& execution);

/// Sets Fragment::sheet, and the areas of sheets in the certificate. Does nothing if the solid has no sheets, or if
/// they stay whole. The set must have a fragment.
///
/// A piece of a sheet goes to the fragment that has its cell. If several do, because the cell is divided among parts
/// or islands, it goes to the one nearest to the middle of the piece. If none does, because the cell has nothing of
/// the solid, it goes to the nearest fragment of all. Ties go to the lower index.
///
/// `diagram`: of all sites, seen through its map; `box`: the box for which it is valid. Sheets outside the box are
/// cut by the diagram of the same sites in a larger box. Near-linear in the pieces and fragments, except for pieces
/// in cells without a fragment. Throws Interrupted.
void carry_sheets(const Solid& solid, const VoronoiDiagram& diagram, const Box& box, FragmentSet& set,
                  const Execution& execution);

}  // namespace fracture
