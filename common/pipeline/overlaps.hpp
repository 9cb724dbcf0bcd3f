// Masses of parts that overlap: space filled by several parts is counted once.
#pragma once

#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Sets Certificate::volume_once and each fragment's Fragment::density_share. Half of the common volume of
/// two parts in contact (Solid::contacts) is subtracted from each, by lowering the density of the whole
/// part. So the masses add up to that of the union, except where three or more parts overlap, and a hit
/// changes no share. A part keeps at least a tenth of its density. `together`: if false, every share is 1.
void count_overlaps_once(const Solid& solid, bool together, FragmentSet& set, const Execution& execution);

}  // namespace fracture
