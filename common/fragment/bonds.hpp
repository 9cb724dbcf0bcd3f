// Bonds: the caps that neighbouring pieces share.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Returns the bonds between groups of pieces. `group_of_piece` maps each piece to its fragment, or to
/// kNoIndex. Bonds ascend by (a, b); those without area are left out. Throws Interrupted.
std::vector<Bond> find_bonds(const RestrictedDiagram& diagram, const Pieces& pieces,
                             const std::vector<std::uint32_t>& group_of_piece,
                             const Execution& execution = kUninterrupted);

}  // namespace fracture
