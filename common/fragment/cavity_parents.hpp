// Which of a cell's pieces hold its uncut cavities: the stated exception of invariant I5, on which only the
// shape of pieces hangs, never closedness.
#pragma once

#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/components.hpp"

namespace fracture {

/// A component without caps is a whole shell; one without positive volume bounds a cavity of the smallest
/// piece of its part that winds around it, or of the only piece of its part, and its faces go there. Where
/// there is no such piece it stays. Pieces are found by a tree of their bounds and wound by a tree of their
/// faces, so that thousands of cavities among thousands of islands are no more than each with its own.
void give_cavities_to_parents(const RestrictedDiagram& diagram, std::vector<Component>& components,
                              Pacer& pacer);

}  // namespace fracture
