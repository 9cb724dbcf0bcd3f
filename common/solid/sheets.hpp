// Turns open sheets (a pane, a leaf, a wall quad) into solids by giving them a thickness.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// The shells that become walls although they enclose a space. Each list has an entry per shell, or is empty.
struct Walled {
  const std::vector<std::uint8_t>& lids;   ///< a large lid closes them
  const std::vector<std::uint8_t>& rooms;  ///< they face inwards
};

/// Replaces certain shells by slabs: flat shells, `walled` shells, and shells whose volume (with filled holes) is less than
/// `thickness` times the area of their source triangles. The source triangles stay where they are and
/// become the front. A copy, moved by `thickness` (metres) against the vertex normals, becomes the back, and
/// walls join their rims.
///
///        front  u ----- v        wall of the open half-edge u->v: triangles v u u' and v u' v',
///               |     / |        the back of u->v runs v'->u'
///        back   u'----- v'
///
/// If the file has the sheet from both sides, the triangles of the other side become the back; otherwise,
/// back and walls have source kNoIndex. Vertex normals are weighted by area. At a fold, vertices move farther,
/// so that the slab is nowhere thinner (a mitre), unless the fold is very sharp. Slabs of sheets bent tighter
/// than the thickness cross themselves. A sheet stays unchanged if its back would be rounded onto its front. (If the file has it from both sides, other
/// choices of the front are tried, up to a limit on the work.)
///
/// The back of a room is its outer side, because its triangles face inwards. It has no rim, so the room becomes a shell
/// around a cavity.
///
/// The report gets the number of rooms, and remarks about slabs that are thinner than requested and about open pieces that
/// filling turned into bodies. Requires a surface without open half-edges, with umbrellas split. Afterwards, vertices
/// must be split again. `fills` (first triangle of each filled hole) is renumbered. Returns the number of
/// slabs.
std::size_t thicken_sheets(Surface& surface, const Shells& shells, double thickness, const Walled& walled,
                           std::vector<TriangleId>& fills, SolidReport& report, const Execution& execution);

}  // namespace fracture::solid_detail
