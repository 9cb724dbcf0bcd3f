// The last stage: assembles pieces, unites pieces without volume with a neighbour, and certifies the
// result.
#pragma once

#include <optional>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/size_limits.hpp"
#include "common/fragment/unions.hpp"
#include "common/fragment/unite.hpp"

namespace fracture {

/// Makes the fragments, their bonds and the certificate. First, pieces are united as `before` says, and
/// then as the size limits ask (unite.hpp). Then each piece whose final rounded volume is not positive is
/// united with the neighbour of largest shared cap area (ties: the lowest piece), until none is left; the
/// caps between them disappear on both sides. If such a piece has no neighbour, it is dropped and counted,
/// and its volume is added to `pocket_volume`.
FragmentSet make_fragments(const RestrictedDiagram& diagram, const Ownership& ownership, Pivot pivot,
                           const SizeLimits& limits, const Execution& execution);
/// Like the above, with the pieces from gather_pieces(). `across`: contacts between pieces of different
/// parts, which are then joined (unite.hpp). If null, pieces of different parts stay separate. `touching`, if
/// not null, receives false if no two fragments touch across parts, because all such pieces were joined.
FragmentSet make_fragments(const RestrictedDiagram& diagram, const Ownership& ownership, Pieces pieces,
                           Pivot pivot, const SizeLimits& limits, const Execution& execution,
                           const std::vector<Union>& before = {}, const PartContacts* across = nullptr,
                           bool* touching = nullptr);

/// Sums over all fragments that prove a result.
struct ProofSums {
  std::uint64_t open_edges = 0, caps = 0;
  double surface_area = 0;  ///< m²
};
/// Fills the values of the certificate that follow from these sums and from its volumes. volume_out and
/// pocket_area must be set before.
void sum_up(const Solid& solid, const ProofSums& sums, Certificate& certificate);
void sum_up(const Solid& solid, const std::vector<Fragment>& fragments, Certificate& certificate);

/// Fills lattice_step and lattice_ratio.
void state_lattice(const Solid& solid, FragmentSet& out);

}  // namespace fracture
