// Where the corners of a solid's triangles are, for searches and measures.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Of triangles [begin, end), metres. Throws Interrupted.
std::vector<std::array<Vec3d, 3>> corners_of(const Solid& solid, std::size_t begin, std::size_t end,
                                             const Execution& execution = {});
/// Of all triangles.
std::vector<std::array<Vec3d, 3>> corners_of(const Solid& solid, const Execution& execution = {});

}  // namespace fracture
