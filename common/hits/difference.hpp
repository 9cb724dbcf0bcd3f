// Finds how an answer differs from an earlier one, and reduces an answer to its changes.
#pragma once

#include "common/base/execution.hpp"
#include "common/hits/delta.hpp"

namespace fracture {

/// Whether two fragments are equal in everything that is written, except hulls and sheets.
bool same_shape(const Fragment& a, const Fragment& b);
/// Whether two fragments carry equal sheets; null: none.
bool same_sheet(const Fragment* a, const Fragment* b);
/// Whether hulls are equal. They can change while the shape does not, if they are trimmed because filters run out.
bool same_hulls(const FragmentHulls& a, const FragmentHulls& b);

/// Directs each bond from its lower to its higher fragment, and sorts the bonds.
void point_upwards(std::vector<Bond>& bonds, const Execution& execution);

/// Compares fragments with the same id. Does not set neighbours. Throws Interrupted.
Delta difference(const FracturedBase& before, const FracturedSolid& after, const Execution& execution = {});

/// Leaves of a rest what concerns the new and changed fragments of the delta: pairs with one of them, and the filters of those
/// with these indices in the whole, ascending.
void keep_rest_of(Rest& rest, const std::vector<std::uint32_t>& fragments, const Delta& delta);

/// Removes the fragments that are neither new nor changed according to the delta (which must exist), with the
/// bonds between such fragments, their hulls and anchors. Sets the delta's neighbours. Certificate and report
/// stay those of the whole, except that anchored fragments are not counted. There must be no hierarchy.
/// Throws Interrupted; the set is then unusable.
void keep_changed(FracturedSolid& fractured, const Execution& execution = {});

}  // namespace fracture
