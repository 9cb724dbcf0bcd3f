// Finds the main colour of each part.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/mesh/mesh.hpp"
#include "common/solid/solid.hpp"

namespace fracture::solid_detail {

/// Sets Part::translucent, and Part::color to the group of similar colours that covers most of the part. So a
/// red roof on white walls does not make the part pink. `source`: the mesh triangle of each triangle of the
/// solid, or kNoIndex. Throws Interrupted.
void color_parts(const Mesh& mesh, const std::vector<std::uint32_t>& source, Solid& solid,
                 const Execution& execution);

}  // namespace fracture::solid_detail
