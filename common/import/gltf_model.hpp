// A checked document as tinygltf's model, with its scene graph. The importer and the renderer share this
// code.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/import/gltf_document.hpp"
#include "common/import/tinygltf_renamed.hpp"
#include "common/import/transform.hpp"

namespace fracture {

/// Loads the plain document, as a GLB in memory, into tinygltf with callbacks that deny access to every file.
/// Takes the document's binary. Throws Refused.
tinygltf::Model load_gltf_model(GltfDocument& document);

/// World transforms of the nodes in the default scene, depth first in the file's order. Other nodes have no
/// transform.
struct GltfScene {
  std::vector<std::optional<Transform>> world;
  std::vector<int> order;
  std::vector<int>
      hidden;  ///< not in `order`: nodes that KHR_node_visibility hides, and the nodes below them
};

/// `center`: added to the translations of the scene's roots (GltfDocument::center). Throws Refused if the nodes are not a
/// tree or refer to something that does not exist.
GltfScene walk_gltf_scene(const tinygltf::Model& model, const Vec3d& center = {});

/// EXT_mesh_gpu_instancing: one transform per instance, or only the identity. Throws Refused.
std::vector<Transform> gltf_instances(const tinygltf::Model& model, const tinygltf::Node& node,
                                      std::uint64_t max_instances);

/// The triangles given by the indices of a primitive: mode 4 (triangles), 5 (strip) or 6 (fan). Triangles
/// that use a vertex twice only join strips and are left out.
std::vector<std::array<std::uint32_t, 3>> gltf_triangles(const std::vector<std::uint32_t>& indices, int mode);

}  // namespace fracture
