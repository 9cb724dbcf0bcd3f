// The last stage: pieces are assembled, those without volume united with a neighbour, and the whole is
// certified.
#pragma once

#include <optional>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/size_limits.hpp"

namespace fracture {

/// Fills everything of FragmentSet but sites_asked and report. A piece whose final rounded volume is not
/// positive is united with the neighbour of largest shared cap area (ties: the lowest piece), their common
/// caps disappearing on both sides, until none is left; a piece without any neighbour is dropped and counted,
/// its volume in `pocket_volume`. Before that, pieces are united as the limits ask (unite.hpp).
FragmentSet make_fragments(const RestrictedDiagram& diagram, const Ownership& ownership, Pivot pivot,
                           const SizeLimits& limits, const Execution& execution);

/// What proves an answer, over all of its fragments.
struct ProofSums {
  std::uint64_t open_edges = 0, caps = 0;
  double surface_area = 0;  ///< m²
};
/// The figures of the certificate that follow from these, and what the volumes (volume_out and pocket_area are
/// there already) come to.
void sum_up(const Solid& solid, const ProofSums& sums, Certificate& certificate);
void sum_up(const Solid& solid, const std::vector<Fragment>& fragments, Certificate& certificate);

/// The lattice and how coarse it is.
void state_lattice(const Solid& solid, FragmentSet& out);

/// Fragments of some owners, numbered as if those of all were there.
struct WantedFragments {
  std::vector<Fragment> fragments;      ///< in their order
  std::vector<double> volumes_file;     ///< m³, per fragment here
  std::vector<std::uint32_t> first_of;  ///< per owner + 1: range of all fragments
  std::vector<Bond> bonds;              ///< of the fragments here, by numbers among all
  std::uint64_t crossing_caps = 0;
};
/// The pieces of the wanted owners alone, one fragment each; nothing where a piece would have to be united or
/// dropped. `others`: per owner that is not wanted, how many fragments it has; bonds to such an owner lead to
/// its first one, whichever of several they belong to.
std::optional<WantedFragments> make_wanted_fragments(const RestrictedDiagram& diagram,
                                                     const Ownership& ownership,
                                                     const std::vector<std::uint32_t>& others, Pivot pivot,
                                                     const Execution& execution);

}  // namespace fracture
