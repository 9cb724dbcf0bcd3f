// Layers: parts with disjoint boxes share one, so that one pass over the surface can treat them together.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture::solid_detail {

/// Greedy colouring in the order of the boxes' lower x (ties by part id): each part gets the lowest layer
/// without a box that touches its own. Returns the number of layers.
///
/// Cost: n log n for boxes that are disjoint, and for boxes that all touch one another; otherwise at most the
/// pairs of boxes that touch.
std::uint32_t assign_layers(std::vector<Part>& parts, const Execution& execution);

}  // namespace fracture::solid_detail
