// The last stage: pieces are assembled, those without volume united with a neighbour, and the whole is
// certified.
#pragma once

#include <optional>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/size_limits.hpp"
#include "common/fragment/unions.hpp"
#include "common/fragment/unite.hpp"

namespace fracture {

struct PieceRecord {
  std::vector<Union> united;          ///< before, or because of their size
  std::vector<std::uint32_t> pieces;  ///< per owner
  bool touch_across =
      true;  ///< false: no two fragments touch across parts, because all such pieces were joined
};

/// Fills everything of FragmentSet but sites_asked and report. A piece whose final rounded volume is not
/// positive is united with the neighbour of largest shared cap area (ties: the lowest piece), their common
/// caps disappearing on both sides, until none is left; a piece without any neighbour is dropped and counted,
/// its volume in `pocket_volume`. Before that, pieces are united as `before` says, and then as the limits ask (unite.hpp).
/// `record`, if not null, says how the fragments came about.
FragmentSet make_fragments(const RestrictedDiagram& diagram, const Ownership& ownership, Pivot pivot,
                           const SizeLimits& limits, const Execution& execution,
                           const std::vector<Union>& before = {}, PieceRecord* record = nullptr);
/// The same with the pieces that gather_pieces() has found. `across`: the contacts of pieces of different parts, which
/// then join (unite.hpp); null: they stay apart.
FragmentSet make_fragments(const RestrictedDiagram& diagram, const Ownership& ownership, Pieces pieces,
                           Pivot pivot, const SizeLimits& limits, const Execution& execution,
                           const std::vector<Union>& before = {}, PieceRecord* record = nullptr,
                           const PartContacts* across = nullptr);

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
  std::vector<std::uint32_t> first_of;  ///< per owner + 1: range of all fragments that begin there
  std::vector<std::uint32_t> pieces;    ///< per owner: how many it has, united ones too
  std::vector<Bond> bonds;              ///< of the fragments here, by numbers among all
  std::vector<Union> late;              ///< what was united beyond `before`; ascending
  std::uint64_t crossing_caps = 0;
  /// Owners that would have to be wanted, too, by their lowest cells: they touch what is too small. Where there are some,
  /// nothing else is filled.
  std::vector<SiteId> further;
};
/// The owners around what is wanted, as the whole has them.
struct OwnersInWhole {
  std::vector<SiteId> lowest;         ///< per owner: of its cells in the whole; ascending
  std::vector<std::uint32_t> others;  ///< per owner that is not wanted: how many fragments it has
};
/// The pieces of the wanted owners alone, united as `before` says, then where they are smaller than `least`, m³; nothing
/// where a piece would have to be united or dropped for its sign. Bonds to an owner that is not wanted lead to its first
/// fragment, whichever of several they belong to.
std::optional<WantedFragments> make_wanted_fragments(const RestrictedDiagram& diagram,
                                                     const Ownership& ownership, const OwnersInWhole& whole,
                                                     const std::vector<Union>& before, double least,
                                                     Pivot pivot, const Execution& execution);

}  // namespace fracture
