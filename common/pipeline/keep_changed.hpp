// How an answer differs from an earlier one, and of such an answer only what is different.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Ids of fragments, each list in the order of its answer. A companion of a FragmentSet.
struct Delta {
  std::vector<std::uint64_t> added, changed, gone;  ///< `changed` ones have a new shape
  /// Untouched fragments that bonds lead to, where the set has only what was added and changed: a bond's
  /// index of fragments.size() + k means neighbors[k].
  std::vector<std::uint64_t> neighbors;
};

/// Takes out of the set what its delta says is neither new nor changed, with the bonds between such fragments;
/// the delta gets the neighbours. The certificate stays that of the whole. For sets without hierarchy. Throws
/// Interrupted; then the set is good for nothing.
void keep_changed(FragmentSet& set, Delta& delta, const Execution& execution = {});

}  // namespace fracture
