// Corner positions of a solid's triangles, for searches and measurements.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Corners of triangles [begin, end), metres. Throws Interrupted.
std::vector<std::array<Vec3d, 3>> corners_of(const Solid& solid, std::size_t begin, std::size_t end,
                                             const Execution& execution = {});
/// Corners of all triangles.
std::vector<std::array<Vec3d, 3>> corners_of(const Solid& solid, const Execution& execution = {});

}  // namespace fracture
