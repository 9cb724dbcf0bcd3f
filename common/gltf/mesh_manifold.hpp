// EXT_mesh_manifold: a closed solid stays one although its vertices are split along attribute seams.
#pragma once

#include <cstddef>

#include "common/fragment/fragments.hpp"
#include "common/gltf/accessors.hpp"
#include "common/gltf/json_text.hpp"

namespace fracture {

/// How many corners of the fragment are at a vertex that is not the first of its topology. Throws InternalError where the
/// topology names a vertex that is not there; Interrupted.
std::size_t merged_corners(const Fragment& fragment, Pacer& pacer);

/// What a fragment's mesh already has in the file.
struct WrittenMesh {
  std::size_t index_view, indices_at;  ///< the run of indices of all primitives
  std::size_t positions;               ///< accessor
  bool wide;                           ///< 32-bit indices
  std::size_t merged;                  ///< merged_corners()
};

/// The mesh's member "EXT_mesh_manifold": a primitive over the whole run of indices in which every corner at
/// a vertex that is not the first of its topology (Fragment::topology) is replaced by that first one (a
/// sparse accessor), and the same replacements as mergeIndices (corners) and mergeValues (vertices).
void write_mesh_manifold(JsonText& json, const Fragment& fragment, const WrittenMesh& mesh,
                         Accessors& accessors);

}  // namespace fracture
