// Chunks that are not convex: cells grown together into fragments of the sizes of a distribution (fragment_sizes.hpp).
// What a cell has of the solid is known to the last bit by then, and who touches whom within the solid, so that groups
// hang together and have the volumes that they should.
//
// An advancing front: the first cell that is free, in the order of the curve through the solid that sites come in,
// begins a fragment, which takes one free neighbour after the other, those near its middle and those in notches of what
// is taken already first. So little is left over behind the front, and what is becomes fragments of the small sizes.
#pragma once

#include <cstdint>
#include <vector>

#include "common/clip/restricted_diagram.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// Do these parameters ask for fragments of several cells?
bool is_aggregated(const SiteParameters& parameters);

/// Per site: cells with equal numbers stay together. As many groups as SiteParameters::sites says, or more where parts
/// of the solid or FractureParameters::max_volume need them; fewer where there are not so many cells. Where the pattern
/// crowds small cells together, there are the small fragments; of impacts, they are longer on the way outwards. n log n
/// in the cells. Throws Interrupted.
std::vector<std::uint32_t> aggregate(const RestrictedDiagram& diagram, const FractureParameters& parameters,
                                     const Execution& execution);

/// How many times as long as wide fragments are on their way out of a hit, roughly.
inline constexpr double kOutwards = 1.8;

}  // namespace fracture
