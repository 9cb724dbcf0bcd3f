// Non-manifold places: duplicate triangles, edges with more than two uses, vertices where several fans touch.
// After these steps the surface is a set of abstract 2-manifolds: every glued edge has two opposite
// triangles, every vertex one fan.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Drops copies of triangles (same three vertices, either orientation). Three or more copies are first
/// reduced by pairs. Of a patch of doubled triangles (connected across edges) one copy is dropped unless that
/// would leave more edges with an odd number of uses than keeping both: a copied face or a double-sided body
/// loses its copy; the common wall of two touching boxes and the two sides of a free sheet stay. The
/// report counts them; the edge table is stale when true is returned.
bool drop_duplicates(Surface& surface, const EdgeTable& edges, SolidReport& report,
                     const Execution& execution);

/// Glues the uses of every edge that is not clean. Around the edge, from its lower to its higher vertex,
/// triangles are sorted by exact angle; turning counter-clockwise one enters the solid at backward uses and
/// leaves it at forward ones, and each entry is glued to the exit that closes its wedge of material, like
/// brackets. So glued sheets never cross, and touching bodies come apart. Triangles at one angle: exits
/// first. Where entries and exits differ in number, patches without open edges are glued first, so that a fin
/// is cut off the body it stands on. What finds no partner stays open. Returns the number of edges with more
/// than two uses.
std::size_t pair_nonmanifold_edges(Surface& surface, const EdgeTable& edges, const Execution& execution);

/// Gives every fan of triangles around a vertex (connected through glued edges) its own vertex: the first fan
/// keeps the id, the others get new ids at the same position. Returns the number of vertices added.
std::size_t split_umbrellas(Surface& surface, const Execution& execution);

}  // namespace fracture::solid_detail
