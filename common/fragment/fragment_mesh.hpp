// A fragment as a mesh again, to be fractured further.
#pragma once

#include <cstddef>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Fragment `index` in the frame of the source, with its attributes; interior triangles have the material
/// kInteriorMaterial, which a solid and its fragments keep. The positions are those of the file where
/// float32(local + pivot) is exact: always with Pivot::kSource, and then input vertices keep their bits.
/// Throws Interrupted.
Mesh fragment_mesh(const FragmentSet& set, std::size_t index, const Execution& execution = {});

}  // namespace fracture
