// Relinks loops that touch at corners. If the tip of a hole is at a corner of the ring around it, the sweep
// cannot determine on which side of that corner the hole is, and may draw a diagonal through the outside.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

/// If several corners of the loops are at one position, each edge that arrives there is continued with the
/// edge that bounds the same wedge of the inside:
///
///     # ^ o v #          # ^ o v #       # is the inside, on the left of each edge. o is a hole, whose tip is at a
///     #  \ /  #          #  | |  #       corner of the ring around it. The edge that arrives with the ring goes on with
///     #   x   #    ->    #  | |  #       the hole, and the edge that arrives with the hole goes on with the ring: they
///     #  / \  #          #  | |  #       become one ring without a hole. In the same way a ring that comes back to a
///     # ^   v #          # ^   v #       place may become two.
///
/// Rings may still touch then, but no wedge contains edges of another ring. If arriving and leaving edges do
/// not alternate around a position, because loops cross there, it is left unchanged. `corners` are indices of
/// points; no two successive corners may be at one position. Loop l is corners[begin[l], begin[l + 1]). Both
/// lists are replaced. Appends triangles without area: together with the triangles of all rings, they use
/// every edge of the loops exactly once. O(n log n). Throws Interrupted.
void link_touching_loops(std::span<const LatticePoint> points, std::vector<std::uint32_t>& corners,
                         std::vector<std::uint32_t>& begin,
                         std::vector<std::array<std::uint32_t, 3>>& triangles,
                         const Execution& execution = kUninterrupted);

/// Returns the positions of the corners of linked rings, in sixteenths of a lattice step, moved towards the
/// inside by up to one step, so that rings no longer touch. Throws Interrupted.
std::vector<LatticePoint> moved_inwards(std::span<const LatticePoint> points,
                                        std::span<const std::uint32_t> corners,
                                        std::span<const std::uint32_t> begin,
                                        const Execution& execution = kUninterrupted);

}  // namespace fracture
