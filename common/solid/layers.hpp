// Layers: parts with disjoint boxes share one, so that one pass over the surface can treat them together.
#pragma once

#include "common/solid/solid.hpp"

namespace fracture::solid_detail {

/// Greedy colouring in the order of the boxes' lower x (ties by part id): each part gets the lowest layer
/// without a box that touches its own. A sweep along x keeps the boxes still open, so the cost is that of the
/// overlapping pairs in x. Returns the number of layers.
std::uint32_t assign_layers(std::vector<Part>& parts);

}  // namespace fracture::solid_detail
