// Masses of parts that overlap: space that several parts fill is counted once.
#pragma once

#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Sets Certificate::volume_once, and Fragment::density_share of each fragment. The common volume of two parts in contact
/// (Solid::contacts) is taken from both in equal halves, as a lower density of each whole part. So the masses add up
/// to that of the union, up to space that three or more parts fill, and a hit changes no share. A part keeps at least a
/// tenth of its density. `together`: if false, every share is 1.
void count_overlaps_once(const Solid& solid, bool together, FragmentSet& set, const Execution& execution);

}  // namespace fracture
