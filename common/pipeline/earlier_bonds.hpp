// Bonds along cuts that were there before a hit. A hit divides the triangles of such a cut among pieces on both sides.
// The pieces that have mirrored triangles share the bond of the two fragments that they come from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/pipeline/kept_fragment.hpp"

namespace fracture {

/// A fragment of the answer after a hit, with its triangles that were cuts before the hit.
struct EarlierCuts {
  const KeptFragment* fragment;
  std::uint32_t number;  ///< in the answer after the hit
  std::uint32_t before;  ///< the fragment that it comes from, in the answer before the hit
  std::span<const IndexRange> caps;
};

/// Divides each of the bonds, which are of the answer before the hit, in proportion to the areas of the mirrored
/// triangles. A bond whose fragments both remain one piece keeps its bits. `cuts` contains the fragments at both ends of
/// all of the bonds. The result is not sorted; a < b. n log n in the triangles. Throws Interrupted.
std::vector<Bond> divided_bonds(std::span<const Bond> bonds, std::span<const EarlierCuts> cuts,
                                const Execution& execution);

}  // namespace fracture
