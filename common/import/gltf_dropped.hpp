// Lists the things in a glTF file that the answer does not contain. They are named as the file names them, or by their JSON
// pointer. Names of scenes, and data about the file itself (asset.generator), are not listed.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/import/gltf_model.hpp"
#include "common/mesh/dropped.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Maximum length of the extras of a node, as JSON text, that its fragments carry. Each fragment has a copy.
inline constexpr std::size_t kMostNodeExtras = 4096;

/// Things outside the scene graph: extensions, lights, cameras, animations, skins, morph targets, material variants,
/// attributes, primitives without triangles, extras. Takes a document as the file states it; tolerates any values.
std::vector<Dropped> dropped_from(const nlohmann::json& document);

/// Maximum number of nodes without a mesh that answers have.
inline constexpr std::size_t kMostEmptyNodes = 1000;

/// The nodes of a scene that show no mesh.
struct OtherNodes {
  std::vector<EmptyNode> kept;
  std::vector<Dropped>
      dropped;  ///< nodes that the answer does not contain, extras, meshes that no node shows
};
/// `document`: that of the model.
OtherNodes other_nodes(const nlohmann::json& document, const tinygltf::Model& model, const GltfScene& scene);

/// Returns the extras of a node that its fragments carry, as the members of a JSON object without its braces. Empty if there
/// are none, if they are not an object, or if they are too long. The results of an earlier fracture are never carried on.
std::string carried_extras(const nlohmann::json& node);

}  // namespace fracture
