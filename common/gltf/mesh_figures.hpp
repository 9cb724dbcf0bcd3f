// What the text of the file says of a mesh's arrays, and whether they fit together.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/fragments.hpp"
#include "common/gltf/vertex_data.hpp"

namespace fracture {

struct MeshFigures {
  Bounds bounds;           ///< of the positions
  std::size_t merged = 0;  ///< merged_corners(), where they are written
};

/// Throws InternalError when the fragment contradicts its own description (attribute lengths, index ranges, primitives that
/// do not cover the indices); Interrupted. `mesh_manifold`: where it has a topology, EXT_mesh_manifold will be written.
MeshFigures measure(const Fragment& fragment, bool mesh_manifold, Pacer& pacer);
/// One for each, on the threads of the execution. Throws as measure().
std::vector<MeshFigures> measure(const std::vector<Fragment>& fragments, bool mesh_manifold,
                                 const Execution& execution);

}  // namespace fracture
