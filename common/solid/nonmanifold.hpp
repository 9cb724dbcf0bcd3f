// Repairs non-manifold places: duplicate triangles, edges with more than two uses, and vertices where several
// fans touch. Afterwards, the surface is a set of abstract 2-manifolds: every glued edge has two triangles in
// opposite directions, and every vertex has one fan.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Drops copies of triangles (the same three vertices, in either orientation). Three or more copies are first
/// reduced in pairs. Then one copy is dropped of each patch of doubled triangles (connected across edges),
/// unless this would leave more edges with an odd number of uses than keeping both. So a copied face or a
/// double-sided body loses its copy, but the common wall of two touching boxes and both sides of a free sheet
/// stay. The report counts the dropped triangles. If the result is true, the edge table is out of date.
bool drop_duplicates(Surface& surface, const EdgeTable& edges, SolidReport& report,
                     const Execution& execution);

/// Glues the uses of every edge that is not clean. Around the edge, seen from its lower to its higher vertex,
/// triangles are sorted by exact angle. Turning counter-clockwise, one enters the solid at backward uses and
/// leaves it at forward ones. Each entry is glued to the exit that closes its wedge of material, like
/// brackets. So glued sheets never cross, and touching bodies come apart. At equal angles, exits come first.
/// If the numbers of entries and exits differ, patches without open edges are glued first, so that a fin is
/// cut off from the body it is attached to. Uses without a partner stay open. Returns the number of edges
/// with more than two uses.
std::size_t pair_nonmanifold_edges(Surface& surface, const EdgeTable& edges, const Execution& execution);

/// Gives every fan of triangles around a vertex (connected through glued edges) its own vertex. The first fan
/// keeps the id, and the others get new ids at the same position. Returns the number of vertices added.
std::size_t split_umbrellas(Surface& surface, const Execution& execution);

}  // namespace fracture::solid_detail
