// How an answer differs from an earlier one, and of such an answer only what is different.
#pragma once

#include "common/base/execution.hpp"
#include "common/hits/kept_answer.hpp"

namespace fracture {

/// Equal in everything that is written of them, but for hulls.
bool same_shape(const Fragment& a, const Fragment& b);
/// Those of an aggregate can change while its shape does not: its neighbours beyond the solid cut them, too.
bool same_hulls(const FragmentHulls& a, const FragmentHulls& b);

/// Each from its lower fragment to its higher one, and in order.
void point_upwards(std::vector<Bond>& bonds, const Execution& execution);

/// Compares fragments that have the same id. Without neighbours. Throws Interrupted.
Delta difference(const FracturedBase& before, const FracturedSolid& after, const Execution& execution = {});

/// The same for the fragments of one cell, which `delta` gets in their order. Returns which of `after` are new or changed.
std::vector<std::uint32_t> differing(const std::vector<KeptFragment>& before,
                                     const std::vector<KeptFragment>& after, Delta& delta,
                                     const Execution& execution);

/// Takes out of the set what the delta (which there must be) says is neither new nor changed, with the bonds
/// between such fragments, their hulls and anchors; the delta gets the neighbours. Certificate and report stay those of
/// the whole, but that nothing counts its anchored fragments. Without hierarchy. Throws Interrupted; then it is good
/// for nothing.
void keep_changed(FracturedSolid& fractured, const Execution& execution = {});

}  // namespace fracture
