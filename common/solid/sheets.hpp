// Open sheets (a pane, a leaf, a wall quad) become solids by a thickness.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Replaces each shell that is flat, or whose holes' fill encloses less than `thickness` times the area of
/// its source triangles, by a slab: the source triangles stay where they are as the front, a copy moved by
/// `thickness` (metres) against the vertex normals is the back, and walls join their rims.
///
///        front  u ----- v        wall of the open half-edge u->v: triangles v u u' and v u' v',
///               |     / |        the back of u->v runs v'->u'
///        back   u'----- v'
///
/// Where the file has the sheet from both sides, the other side's triangles become the back; otherwise back
/// and walls have source kNoIndex. Vertex normals are area-weighted, so that a fold gets thinner by its
/// angle, and slabs of sheets bent tighter than the thickness cross themselves. A sheet whose back would
/// round onto its front stays as it is (where the file has it from both sides, other choices of the front are
/// tried, up to a bound on the work). What is thinner than asked, and what holes' fill made a body of, is a note of the
/// report. Needs a surface without open half-edges, with umbrellas split; leaves
/// vertices to be split again. `fills` (first triangle of each filled hole) follows the renumbering. Returns
/// the number of slabs.
std::size_t thicken_sheets(Surface& surface, const Shells& shells, double thickness,
                           std::vector<TriangleId>& fills, SolidReport& report, const Execution& execution);

}  // namespace fracture::solid_detail
