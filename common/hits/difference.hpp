// Finds how an answer differs from an earlier one, and reduces an answer to its changes.
#pragma once

#include "common/base/execution.hpp"
#include "common/hits/kept_answer.hpp"

namespace fracture {

/// Whether two fragments are equal in everything that is written, except hulls and sheets.
bool same_shape(const Fragment& a, const Fragment& b);
/// Whether two fragments carry equal sheets; null: none.
bool same_sheet(const Fragment* a, const Fragment* b);
/// The sheets of a kept fragment of the answer before; null if it has none.
const Fragment* sheet_before(const FracturedBase& before, const Fragment& kept);
/// Whether hulls are equal. An aggregate's hulls can change while its shape does not, because neighbours
/// beyond the solid also cut them.
bool same_hulls(const FragmentHulls& a, const FragmentHulls& b);

/// Directs each bond from its lower to its higher fragment, and sorts the bonds.
void point_upwards(std::vector<Bond>& bonds, const Execution& execution);

/// Compares fragments with the same id. Does not set neighbours. Throws Interrupted.
Delta difference(const FracturedBase& before, const FracturedSolid& after, const Execution& execution = {});

/// The same for the fragments of one cell; appends to `delta` in their order. Returns the indices of those in
/// `after` that are new or changed.
std::vector<std::uint32_t> differing(const std::vector<KeptFragment>& before,
                                     const std::vector<KeptFragment>& after, Delta& delta,
                                     const Execution& execution);

/// Leaves of a rest what concerns the new and changed fragments of the delta: pairs with one of them, and the filters of those
/// with these indices in the whole, ascending.
void keep_rest_of(Rest& rest, const std::vector<std::uint32_t>& fragments, const Delta& delta);

/// Removes the fragments that are neither new nor changed according to the delta (which must exist), with the
/// bonds between such fragments, their hulls and anchors. Sets the delta's neighbours. Certificate and report
/// stay those of the whole, except that anchored fragments are not counted. There must be no hierarchy.
/// Throws Interrupted; the set is then unusable.
void keep_changed(FracturedSolid& fractured, const Execution& execution = {});

}  // namespace fracture
