// The material of a part, for everything that treats a part as one body.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Returns, for each part, the material that covers most of its surface in the source: an index into the materials, or kNoIndex
/// for surface without one. If two materials cover equal areas, the result is the earlier one. A part without surface in the
/// source has kInteriorMaterial. Throws Interrupted.
std::vector<std::uint32_t> main_materials(const Solid& solid, const Execution& execution);

}  // namespace fracture
