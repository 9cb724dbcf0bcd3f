// Numbers about a mesh's arrays that the JSON text needs, and a check that the arrays are consistent.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/fragments.hpp"
#include "common/gltf/vertex_data.hpp"

namespace fracture {

struct MeshFigures {
  Bounds bounds;           ///< of the positions
  std::size_t merged = 0;  ///< merged_corners(), if EXT_mesh_manifold is written
};

/// Throws InternalError if the fragment is inconsistent (attribute lengths, index ranges, primitives that do not cover the
/// indices). Throws Interrupted. `mesh_manifold`: EXT_mesh_manifold will be written for fragments with a topology.
MeshFigures measure(const Fragment& fragment, bool mesh_manifold, Pacer& pacer);
/// Measures all fragments on the execution's threads. Throws the same exceptions.
std::vector<MeshFigures> measure(const std::vector<Fragment>& fragments, bool mesh_manifold,
                                 const Execution& execution);

}  // namespace fracture
