// Loops that touch in corners, linked anew. If the tip of a hole is at a corner of the ring around it, the sweep cannot tell
// on which side of that corner the hole lies, and may draw a diagonal through the outside.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

/// If several corners of the loops are at one place, each edge that arrives there goes on with the edge that bounds
/// the same wedge of the inside:
///
///     # ^ o v #          # ^ o v #       # is the inside, on the left of each edge. o is a hole, whose tip is at a
///     #  \ /  #          #  | |  #       corner of the ring around it. The edge that arrives with the ring goes on with
///     #   x   #    ->    #  | |  #       the hole, and the edge that arrives with the hole goes on with the ring: they
///     #  / \  #          #  | |  #       become one ring without a hole. In the same way a ring that comes back to a
///     # ^   v #          # ^   v #       place may become two.
///
/// Rings still touch then, but no wedge holds the edges of another one. If arriving and leaving edges do not alternate
/// around a place, because loops cross there, it stays as it is. `corners` are indices of points; no two successive ones
/// are at one place; loop l is corners[begin[l], begin[l + 1]). Both are replaced. Appends triangles without area: with
/// the triangles of all rings, every edge of the loops is used exactly once. n log n. Throws Interrupted.
void link_touching_loops(std::span<const LatticePoint> points, std::vector<std::uint32_t>& corners,
                         std::vector<std::uint32_t>& begin,
                         std::vector<std::array<std::uint32_t, 3>>& triangles,
                         const Execution& execution = kUninterrupted);

/// The places of the corners of linked rings, in sixteenths of a lattice step and moved towards the inside by up to one
/// step, so that rings do not touch any more. Throws Interrupted.
std::vector<LatticePoint> moved_inwards(std::span<const LatticePoint> points,
                                        std::span<const std::uint32_t> corners,
                                        std::span<const std::uint32_t> begin,
                                        const Execution& execution = kUninterrupted);

}  // namespace fracture
