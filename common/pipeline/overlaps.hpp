// Masses of parts that overlap: space filled by several parts is counted once.
#pragma once

#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Returns the density of each part as a share of its material's density, as described below; empty if no parts overlap. Throws
/// Interrupted.
std::vector<double> density_shares(const Solid& solid, const Execution& execution);

/// Sets Certificate::volume_once, and Fragment::density_share of each fragment. Parts that overlap, directly or through
/// others, are a group. The volume of its union is estimated as the sum of its parts minus the overlaps of pairs
/// (Solid::contacts; exact unless three parts fill the same space, see Bonferroni 1936), but at least its largest part.
/// All parts of a group get the same lower density, so that their masses add up to that of the union, and no hit changes
/// a share. `together`: if false, every share is 1.
void count_overlaps_once(const Solid& solid, bool together, FragmentSet& set, const Execution& execution);

/// The volume, m³, that Certificate::volume_once states if parts are together. Throws Interrupted.
double volume_once(const Solid& solid, const Execution& execution);

}  // namespace fracture
