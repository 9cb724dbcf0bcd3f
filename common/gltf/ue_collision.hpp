// Collision hulls for Unreal's importer, which recognizes them by name.
#pragma once

#include "common/gltf/json_text.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

/// Writes the UCX_<fragment>_NN nodes of a fragment into the array of nodes. They are children of the fragment, without a
/// transform, and draw its hull meshes. They have no extras.fracture, so no reader takes them for fragments.
void write_ucx_nodes(JsonText& json, std::size_t fragment, const SceneLayout& layout);

}  // namespace fracture
