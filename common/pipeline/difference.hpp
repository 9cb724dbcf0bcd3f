// How an answer differs from an earlier one, and of such an answer only what is different.
#pragma once

#include <cstdint>
#include <functional>

#include "common/base/execution.hpp"
#include "common/pipeline/delta.hpp"

namespace fracture {

/// `kept(k)`: is fragment k of `after` known to be one of `before` as it was? The others are compared by all
/// that is written of them. Throws Interrupted.
Delta difference(const FracturedBase& before, const std::vector<Fragment>& after,
                 const std::function<bool(std::uint32_t)>& kept, const Execution& execution = {});

/// Takes out of the set what the delta (which there must be) says is neither new nor changed, with the bonds
/// between such fragments, their hulls and anchors; the delta gets the neighbours. Certificate, report and the
/// number of anchored fragments stay those of the whole. Without hierarchy. Throws Interrupted; then it is good for nothing.
void keep_changed(FracturedSolid& fractured, const Execution& execution = {});

}  // namespace fracture
