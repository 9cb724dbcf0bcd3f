// All clipping stages in their order.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// surface cuts -> winding numbers -> positions -> caps. Keeps references to the solid and the diagram.
/// `image` is image_of(solid, *diagram.map()): it decides, the solid has the positions. Without a map it is
/// the solid itself.
RestrictedDiagram restrict_to_solid(const Solid& solid, const Solid& image, const VoronoiDiagram& diagram,
                                    const Execution& execution);

}  // namespace fracture
