// The offset of a glTF scene that is far from the origin (file_positions.hpp). It is subtracted from the nodes' transforms,
// which are doubles, before any position is rounded.
#pragma once

#include <cstdint>

#include "common/import/gltf_model.hpp"

namespace fracture {

/// The offset of the scene. Uses the bounds that accessors state, and the transforms of nodes, instances and joints. So it
/// costs no more for a large mesh than for a small one. Throws Refused.
Vec3d gltf_offset(const tinygltf::Model& model, const GltfScene& scene, std::uint64_t max_instances);

/// Moves the whole scene by -offset.
void subtract(const Vec3d& offset, GltfScene& scene);

}  // namespace fracture
