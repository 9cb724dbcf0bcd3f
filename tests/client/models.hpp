// Scenes made by hand, and glTF texts, whose pictures can be predicted.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/render/model.hpp"

namespace fracture::test {

/// Adds an object with the six faces of a box around its origin, moved to `center`. The faces towards +x, -x,
/// +y, -y, +z, -z have the materials materials[0 … 5].
void add_box(render::Model& model, glm::vec3 center, glm::vec3 size,
             const std::array<std::uint32_t, 6>& materials);
inline void add_box(render::Model& model, glm::vec3 center, glm::vec3 size, std::uint32_t material = 0) {
  add_box(model, center, size, {material, material, material, material, material, material});
}

/// A dull material with this colour (linear).
render::Material paint(glm::vec3 color);
/// Sorts surfaces by material, which is the order in which read_model leaves them.
void sort_by_material(render::Model& model);

/// The unit cube as `per_side`³ fragments with ids 0, 1, …; material 0.
render::Model cube_of_fragments(int per_side, glm::vec3 color = glm::vec3(0.8f, 0.1f, 0.1f));

/// A primitive of a glTF text. Empty members are left out.
struct GltfPrimitive {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec2> uvs;
  std::vector<std::uint32_t> indices;
  int material = -1, mode = 4;
};

/// A glTF text with one mesh on one node; `node` and `document` are merged in (transforms, materials,
/// images).
std::string gltf_text(const std::vector<GltfPrimitive>& primitives,
                      const nlohmann::json& node = nlohmann::json::object(),
                      const nlohmann::json& document = nlohmann::json::object());

std::string base64(const std::vector<unsigned char>& bytes);

}  // namespace fracture::test
