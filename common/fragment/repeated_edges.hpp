// Separates edges that a fragment's topology uses more than once in the same direction. Such edges occur if
// two faces have a diagonal between the same two vertices: in triangles without area, or if the solid
// touches itself.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Splits vertices until each edge of the topology is used exactly once in each direction:
///
///         x1               x1        Two pairs of triangles share the edge a b. Each triangle gets its partner from the
///        /  \             /  \       other pair if both pairs are in one fan at a and in one fan at b; that cuts both fans
///       a----b    ->     a'---b'     in two. Then each fan of triangles at a and b, connected across paired edges, has a
///        \  /             \  /       vertex of its own. All copies are at the same position, with the same attributes.
///         y1               y2
///
/// Triangles with two corners at one vertex are dropped first. No other triangle moves, so volumes, areas and
/// mirror images do not change. New vertices are appended; the others keep their numbers. The time is
/// O(n log n) in the number of triangles. Returns false if nothing changed. If an edge has no opposite,
/// nothing is split. Throws Interrupted.
bool split_repeated_edges(Fragment& fragment, const Execution& execution = kUninterrupted);

}  // namespace fracture
