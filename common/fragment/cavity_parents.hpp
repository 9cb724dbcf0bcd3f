// Assigns uncut cavities to the pieces of a cell that contain them. This is the stated exception to
// invariant I5. Only the shape of pieces depends on it, never their closedness.
#pragma once

#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/components.hpp"

namespace fracture {

/// Adds the faces of cavities to the pieces around them. A component without caps is a whole shell; if its
/// volume is not positive, it bounds a cavity. The cavity goes to the smallest piece of its part that winds
/// around it, or to the only piece of its part. If there is no such piece, it remains a component. A tree
/// of bounds finds candidate pieces, and a tree of faces computes winding numbers. So thousands of cavities
/// among thousands of islands take near-linear time.
void give_cavities_to_parents(const RestrictedDiagram& diagram, std::vector<Component>& components,
                              Pacer& pacer);

}  // namespace fracture
