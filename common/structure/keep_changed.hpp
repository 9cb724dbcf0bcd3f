// Of an answer that says how it differs from an earlier one only what is different.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Takes out of the set what its delta (which it must have) says is neither new nor changed, with the bonds
/// between such fragments. The certificate and the report stay those of the whole. For sets without
/// hierarchy. Throws Interrupted; then the set is good for nothing.
void keep_changed(FragmentSet& set, const Execution& execution = {});

}  // namespace fracture
