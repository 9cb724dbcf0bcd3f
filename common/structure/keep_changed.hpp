// Of an answer that says how it differs from an earlier one only what is different.
#pragma once

#include "common/fragment/fragments.hpp"

namespace fracture {

/// Takes out of the set what its delta (which it must have) says is neither new nor changed, with the bonds
/// between such fragments. The certificate and the report stay those of the whole. For sets without
/// hierarchy.
void keep_changed(FragmentSet& set);

}  // namespace fracture
