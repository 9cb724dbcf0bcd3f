// Layers: parts with disjoint boxes share a layer, so one pass over the surface can process them together.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture::solid_detail {

/// Assigns layers by greedy colouring, in the order of the boxes' lower x (ties by part id). Each part gets
/// the lowest layer in which no box touches its own. Returns the number of layers.
///
/// Cost: n log n if all boxes are disjoint, or if all touch one another; otherwise at most the number of
/// pairs of boxes that touch.
std::uint32_t assign_layers(std::vector<Part>& parts, const Execution& execution);

}  // namespace fracture::solid_detail
