// Fractures an object of several materials (FractureParameters::assigned). Parts with the same parameters are a *set*. Each set is
// a solid of its own, with its own diagram. The pieces of all sets are then one set of fragments, which is checked,
// bonded across parts and completed as a whole. Parts of different sets share no cells, so their pieces never become one
// fragment.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/pipeline/fracture.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/solid/part_selection.hpp"

namespace fracture {

/// Parts of a solid that break with the same parameters.
struct PartSet {
  std::vector<std::uint32_t> parts{};  ///< part numbers in the whole mesh, ascending; empty: all parts
  std::optional<Solid> own{};          ///< these parts; not set if they are all parts
  FractureParameters parameters{};     ///< without assigned parts

  const Solid& solid_in(const Solid& whole) const { return own ? *own : whole; }
};

/// Returns the parts that each entry of `assigned` decides.
PartChoice choose_assigned(const Solid& solid, const FractureParameters& parameters,
                           const Execution& execution);

/// Returns one sentence for each entry of `assigned` that decides no part (solid/part_selection.hpp).
std::vector<std::string> warnings_of_assigned(const Solid& solid, const FractureParameters& parameters,
                                              const PartChoice& choice);

/// Returns the sets that have parts: first the parts that no entry matches, then those of each entry. `fragments`, `sites`,
/// `max_fragments` and `max_triangles` of the request are shared among the sets by volume (D'Hondt 1882, as in PartQuotas),
/// and each set gets as many fragments as it has parts, or groups of parts in contact. Each connected sheet belongs to the set of the
/// nearest part. Throws Interrupted.
std::vector<PartSet> part_sets(const Solid& solid, const FractureParameters& parameters,
                               const Execution& execution);

/// Returns the sets whose boxes the hit reaches, with the box of the whole, so that cuts are rounded to the same lattice. Nothing is
/// shared among them, because the limits of hits concern the whole. If the hit reaches no set, returns one of all parts. Throws
/// Interrupted.
std::vector<PartSet> sets_near_hit(const Solid& solid, const FractureParameters& parameters,
                                   const LocalImpact& hit, const Execution& execution);

/// Makes the diagram of each set, and a diagram of the whole, which has their sites (Diagram::sets). Errors: those of
/// make_diagram(), kTooComplex (more than most_sites in all sets together). Throws Interrupted.
Expected<Diagram> diagram_of_sets(const Solid& solid, const FractureParameters& parameters,
                                  const Execution& execution);

/// Cuts each set by its diagram, and returns the pieces of all sets, with the parts and sites of the whole. `cut` cuts one set.
/// Errors: those of `cut`. Throws Interrupted.
Expected<CutCells> cut_sets(
    const Solid& solid, const Diagram& diagram, const std::vector<PartSet>& sets, const Execution& execution,
    const std::function<Expected<CutCells>(const Solid&, const Diagram&, const FractureParameters&)>& cut);

/// Multiplies the densities of fragments and the strengths of bonds by those that are assigned to their parts. The weaker part
/// decides a bond; a node that stays whole is as strong as the request's material. To be called once all bonds are known and
/// overlaps were counted. `together`: as in count_overlaps_once(). Sets FragmentSet::weighed_volume, except with dual=barycenter.
/// Throws Interrupted.
void weigh_assigned(const Solid& solid, const FractureParameters& parameters, const PartChoice& choice,
                    bool together, FragmentSet& set, std::vector<WholeBond>& whole_bonds,
                    const Execution& execution);

/// With dual=barycenter, sets FragmentSet::weighed_volume from the set's fragments, because hulls of barycentres are not a partition
/// of the solid. To be called before hits: later, the sum would have other terms, and its last bits would change the masses of
/// fragments that no hit touches. Otherwise does nothing. Throws Interrupted.
void weigh_before_hits(const Solid& solid, const FractureParameters& parameters, FragmentSet& set,
                       const Execution& execution);

/// Returns the parameters for the parts that an entry of `assigned` decides (kNoIndex: none), before sites and fragments are
/// shared.
FractureParameters parameters_of_entry(const FractureParameters& parameters, std::uint32_t entry);

/// Replaces what an entry decides by AssignedParts::breaks, and the number of sites if these are points.
void take_entry(FractureParameters& parameters, const FractureParameters& breaks);

/// Returns the parameters for the report: those of the request, with the greatest roughness of any parts.
FractureParameters reported_parameters(const FractureParameters& parameters);

}  // namespace fracture
