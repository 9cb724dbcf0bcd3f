// Pieces that a file has from both sides although they are vessels with an opening, not sheets.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Share of a piece's area that must be there from both sides.
inline constexpr double kNearlyAll = 0.95;
/// The fills of an open vessel have at most this share of its area, which is counted without fills. The opening of a
/// hemisphere has half of its area, and a bowl of this share is 0.58 times as deep as its radius. The fills of flat and
/// bent sheets (leaves, cloth, terrain) have about as much area as the sheet.
inline constexpr double kMostOpening = 0.75;
/// With both sides, a vessel bounds no volume: at most this share of the volume that its outer side encloses. Bodies that touch with
/// most of their faces have common walls from both sides, too, but bound their volume.
inline constexpr double kMostBefore = 0.5;

/// Some programs (SketchUp, and sets of models made with it) write every triangle twice, once for each side. Such a
/// piece is closed, but bounds no volume. This function looks at pieces (triangles connected across edges) of which
/// nearly all triangles are doubled. It closes one side of each like any open surface. The piece is a
/// vessel if that gives a body, the fills are small (kMostOpening), and the piece bounded almost no volume before (kMostBefore). Then
/// the triangles of its inner side are removed, so that it is closed like a vessel with one side. Otherwise, both sides
/// stay.
///
/// `tolerance`: of seams, m (see fill_holes()). The report counts the removed triangles as duplicates. If the result is
/// true, the edge table is out of date. n log n. Throws Interrupted.
bool drop_inner_sides(Surface& surface, const EdgeTable& edges, double tolerance, SolidReport& report,
                      const Execution& execution);

}  // namespace fracture::solid_detail
