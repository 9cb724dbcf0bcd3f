// All clipping stages in their order.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// surface cuts -> winding numbers -> positions -> caps. Keeps references to both arguments.
RestrictedDiagram restrict_to_solid(const Solid& solid, const VoronoiDiagram& diagram,
                                    const Execution& execution);

}  // namespace fracture
