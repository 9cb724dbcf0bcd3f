// What colour each part has on the whole.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/mesh/mesh.hpp"
#include "common/solid/solid.hpp"

namespace fracture::solid_detail {

/// Sets Part::color: of the colours of the part's source triangles the group that covers most of it, so that a red
/// roof on white walls does not make it pink; and Part::translucent. `source`: for each triangle of the solid that
/// of the mesh, or kNoIndex. Throws Interrupted.
void color_parts(const Mesh& mesh, const std::vector<std::uint32_t>& source, Solid& solid,
                 const Execution& execution);

}  // namespace fracture::solid_detail
