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

struct PieceRecord {
  std::vector<Union> united;          ///< repeated unions and those made because of size
  std::vector<std::uint32_t> pieces;  ///< per owner: number of pieces
  bool touch_across =
      true;  ///< false if no two fragments touch across parts, because all such pieces were joined
};

/// Makes the fragments, their bonds and the certificate. First, pieces are united as `before` says, and
/// then as the size limits ask (unite.hpp). Then each piece whose final rounded volume is not positive is
/// united with the neighbour of largest shared cap area (ties: the lowest piece), until none is left; the
/// caps between them disappear on both sides. If such a piece has no neighbour, it is dropped and counted,
/// and its volume is added to `pocket_volume`. `record`, if not null, receives how the fragments were made.
FragmentSet make_fragments(const RestrictedDiagram& diagram, const Ownership& ownership, Pivot pivot,
                           const SizeLimits& limits, const Execution& execution,
                           const std::vector<Union>& before = {}, PieceRecord* record = nullptr);
/// Like the above, with the pieces from gather_pieces(). `across`: contacts between pieces of different
/// parts, which are then joined (unite.hpp). If null, pieces of different parts stay separate.
FragmentSet make_fragments(const RestrictedDiagram& diagram, const Ownership& ownership, Pieces pieces,
                           Pivot pivot, const SizeLimits& limits, const Execution& execution,
                           const std::vector<Union>& before = {}, PieceRecord* record = nullptr,
                           const PartContacts* across = nullptr);

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

/// Fragments of the wanted owners, numbered as if those of all owners existed.
struct WantedFragments {
  std::vector<Fragment> fragments;      ///< ascending by their numbers
  std::vector<double> volumes_file;     ///< m³, per fragment here
  std::vector<std::uint32_t> first_of;  ///< per owner, plus one entry: number of its first fragment
  std::vector<std::uint32_t> pieces;    ///< per owner: number of pieces, including united ones
  std::vector<Bond> bonds;              ///< of these fragments; a and b are numbers among all fragments
  std::vector<Union> late;              ///< unions beyond `before`; ascending
  std::uint64_t crossing_caps = 0;
  /// Other owners that must be wanted, too, by their lowest cells: they touch a group that is too small. If
  /// there are any, no fragments are made.
  std::vector<SiteId> further;
};
/// The same owners in the whole diagram.
struct OwnersInWhole {
  std::vector<SiteId> lowest;         ///< per owner: its lowest cell in the whole; ascending
  std::vector<std::uint32_t> others;  ///< per owner that is not wanted: its number of fragments
};
/// Makes the fragments of the wanted owners only. Pieces are united as `before` says, then those smaller
/// than `least`, m³. Returns nothing if a piece would have to be united or dropped because its volume is
/// not positive. Bonds with an owner that is not wanted lead to its first fragment, even if they belong to
/// another one.
std::optional<WantedFragments> make_wanted_fragments(const RestrictedDiagram& diagram,
                                                     const Ownership& ownership, const OwnersInWhole& whole,
                                                     const std::vector<Union>& before, double least,
                                                     Pivot pivot, const Execution& execution);

}  // namespace fracture
