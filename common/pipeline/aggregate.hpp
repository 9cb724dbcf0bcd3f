// Chunks that are not convex: groups of cells that grow into fragments with a given size distribution
// (fragment_sizes.hpp). At this stage, each cell's share of the solid is known exactly, and so is which
// cells touch within the solid. So each group is connected and has the volume that it should have.
//
// The method is an advancing front. The first free cell, in the order of the curve through the solid along
// which sites are sorted, begins a fragment. The fragment takes one free neighbour after another: first
// those near its middle, and those in notches between taken cells. So few cells are left over behind the
// front, and these become small fragments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/restricted_diagram.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// Whether these parameters ask for fragments of several cells.
bool is_aggregated(const SiteParameters& parameters);

/// Returns a number per site; cells with equal numbers stay together. There are as many groups as
/// SiteParameters::sites says. There are more if parts of the solid or FractureParameters::max_volume need
/// them, and fewer if there are not enough cells. If the pattern crowds small cells together, the small
/// fragments are there. Around `impacts`, fragments are longer in the direction away from the impact. The cells
/// `kept` are one group; the number of the other groups falls with the volume that is left, unless
/// SizeLimits::fragments is set. Takes n log n
/// in the number of cells. Throws Interrupted.
std::vector<std::uint32_t> aggregate(const RestrictedDiagram& diagram, const FractureParameters& parameters,
                                     std::span<const Vec3d> impacts, std::span<const SiteId> kept,
                                     const Execution& execution);

/// Approximate ratio of length to width of fragments, in the direction away from a hit.
inline constexpr double kOutwards = 1.8;

}  // namespace fracture
