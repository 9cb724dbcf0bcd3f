// A checked document as tinygltf's model, and its scene graph: what the importer and the renderer share.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/import/gltf_document.hpp"
#include "common/import/tinygltf_renamed.hpp"
#include "common/import/transform.hpp"

namespace fracture {

/// The plain document as a GLB in memory, given to tinygltf with callbacks that deny every file. Takes the
/// document's binary. Throws Refused.
tinygltf::Model load_gltf_model(GltfDocument& document);

/// World transforms of the nodes of the default scene, depth first in the file's order. Nodes outside keep
/// nothing.
struct GltfScene {
  std::vector<std::optional<Transform>> world;
  std::vector<int> order;
};

/// Throws Refused where the nodes are no tree or name what does not exist.
GltfScene walk_gltf_scene(const tinygltf::Model& model);

/// EXT_mesh_gpu_instancing: one transform for each instance, or the identity alone. Throws Refused.
std::vector<Transform> gltf_instances(const tinygltf::Model& model, const tinygltf::Node& node,
                                      std::uint64_t max_instances);

/// The triangles that the indices of a primitive make: mode 4 (triangles), 5 (strip) or 6 (fan). Triangles of
/// strips and fans that name a vertex twice are left out: they stitch.
std::vector<std::array<std::uint32_t, 3>> gltf_triangles(const std::vector<std::uint32_t>& indices, int mode);

}  // namespace fracture
