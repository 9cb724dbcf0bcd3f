// Collision hulls as Unreal's importer looks for them: by name.
#pragma once

#include "common/gltf/json_text.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

/// The UCX_<fragment>_NN nodes of a fragment, elements of the array of nodes: children of the fragment at the
/// identity that draw its hull meshes, without extras.fracture, so that nothing takes them for fragments.
void write_ucx_nodes(JsonText& json, std::size_t fragment, const SceneLayout& layout);

}  // namespace fracture
