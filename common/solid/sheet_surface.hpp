// The surface of sheets: triangles that bound no volume but stay in the answer.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Returns the sheets made of these triangles of the source (ascending), except for triangles without area.
/// Null if none is left. `solid_box`: box of the solid to which they belong. n log n. Throws Interrupted.
std::shared_ptr<const Sheets> make_sheets(std::shared_ptr<const Mesh> source,
                                          const std::vector<std::uint32_t>& triangles, const Box& solid_box,
                                          bool whole, const Execution& execution);

}  // namespace fracture
