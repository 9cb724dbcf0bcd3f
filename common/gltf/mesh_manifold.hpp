// EXT_mesh_manifold: keeps a solid closed for readers although its vertices are split along attribute seams.
#pragma once

#include <cstddef>

#include "common/fragment/fragments.hpp"
#include "common/gltf/accessors.hpp"
#include "common/gltf/json_text.hpp"

namespace fracture {

/// Number of triangle corners whose vertex is not the first one of its topology. Throws InternalError if the topology has a
/// vertex index out of range. Throws Interrupted.
std::size_t merged_corners(const Fragment& fragment, Pacer& pacer);

/// The data of a fragment's mesh that is already in the file.
struct WrittenMesh {
  std::size_t index_view, indices_at;  ///< the run of indices of all primitives
  std::size_t positions;               ///< accessor
  bool wide;                           ///< 32-bit indices
  std::size_t merged;                  ///< merged_corners()
};

/// Writes the mesh's member "EXT_mesh_manifold". It has a primitive with all indices, in which a sparse accessor
/// replaces each vertex by the first one of its topology (Fragment::topology). It also lists these replacements as
/// mergeIndices (corners) and mergeValues (vertices).
void write_mesh_manifold(JsonText& json, const Fragment& fragment, const WrittenMesh& mesh,
                         Accessors& accessors);

}  // namespace fracture
