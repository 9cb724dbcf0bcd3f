// The shared caps of neighbouring pieces.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// The bonds between groups of pieces: `group_of_piece` maps a piece to its fragment (kNoIndex: to none).
/// Ascending by (a, b); bonds without area are left out. Throws Interrupted.
std::vector<Bond> find_bonds(const RestrictedDiagram& diagram, const Pieces& pieces,
                             const std::vector<std::uint32_t>& group_of_piece,
                             const Execution& execution = kUninterrupted);

}  // namespace fracture
