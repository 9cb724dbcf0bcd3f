// Finds the two sides of sheets that a file has from both sides.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// For each of the triangles: the triangle with the same three positions in reverse order, or kNoTriangle.
/// n log n. Throws Interrupted.
std::vector<TriangleId> find_mirrors(const Surface& surface, const std::vector<TriangleId>& triangles,
                                     const Execution& execution);

}  // namespace fracture::solid_detail
