// Converts a fragment back to a mesh, so that it can be fractured further.
#pragma once

#include <cstddef>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Returns fragment `index` as a mesh in the source's frame, with its attributes. Interior triangles have
/// the material kInteriorMaterial, which a solid and its fragments keep. The positions equal those of the
/// file if float32(local + pivot) is exact. With Pivot::kSource it always is, and input vertices keep their
/// bits. Throws Interrupted.
Mesh fragment_mesh(const FragmentSet& set, std::size_t index, const Execution& execution = {});

}  // namespace fracture
