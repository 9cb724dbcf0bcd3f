#include "tests/client/models.hpp"

#include <algorithm>
#include <cstring>

namespace fracture::test {

using render::Material;
using render::Model;
using render::Object;
using render::Surface;
using render::Vertex;

void add_box(Model& model, glm::vec3 center, glm::vec3 size, const std::array<std::uint32_t, 6>& materials) {
  const auto number = static_cast<std::uint32_t>(model.objects.size());
  for (std::size_t face = 0; face < 6; ++face) {
    const int axis = static_cast<int>(face / 2);
    glm::vec3 n(0), u(0), v(0);
    n[axis] = face % 2 == 0 ? 1.f : -1.f;
    u[(axis + 1) % 3] = 1;
    v = glm::cross(n, u);
    Surface surface{number, materials[face], static_cast<std::uint32_t>(model.indices.size()), 6};
    const auto base = static_cast<std::uint32_t>(model.vertices.size());
    for (const auto& [a, b] : {std::pair{-1.f, -1.f}, {1.f, -1.f}, {1.f, 1.f}, {-1.f, 1.f}}) {
      Vertex vertex;
      vertex.position = 0.5f * size * (n + a * u + b * v);
      vertex.normal = n;
      vertex.object = number;
      model.vertices.push_back(vertex);
    }
    for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) model.indices.push_back(base + k);
    model.surfaces.push_back(surface);
  }
  Object object;
  object.transform[3] = glm::vec4(center, 1);
  object.bounds = {glm::vec3(0), 0.5f * glm::length(size)};
  model.objects.push_back(object);
}

Material paint(glm::vec3 color) {
  Material m;
  m.base_color = glm::vec4(color, 1);
  m.metallic = 0;
  m.roughness = 1;
  return m;
}

void sort_by_material(Model& model) {
  std::stable_sort(model.surfaces.begin(), model.surfaces.end(),
                   [](const Surface& a, const Surface& b) { return a.material < b.material; });
}

Model cube_of_fragments(int per_side, glm::vec3 color) {
  Model model;
  model.materials.push_back(paint(color));
  const float side = 1.f / static_cast<float>(per_side);
  for (int z = 0; z < per_side; ++z)
    for (int y = 0; y < per_side; ++y)
      for (int x = 0; x < per_side; ++x) {
        const glm::vec3 center = side * (glm::vec3(x, y, z) + 0.5f) - 0.5f;
        add_box(model, center, glm::vec3(side));
        render::FragmentInfo info;
        info.id = static_cast<std::uint32_t>(model.objects.size() - 1);
        info.volume = side * side * side;
        info.centroid = center;
        info.ancestors = {1000u + static_cast<std::uint32_t>(x),
                          static_cast<std::uint32_t>(info.id)};  // groups: slabs across x
        model.objects.back().fragment = info;
      }
  return model;
}

std::string base64(const std::vector<unsigned char>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const auto at = [&](std::size_t i) { return i < bytes.size() ? unsigned{bytes[i]} : 0u; };
    const unsigned group = at(k) << 16 | at(k + 1) << 8 | at(k + 2);
    for (std::size_t d = 0; d < 4; ++d)
      text += k + d > bytes.size() ? '=' : kDigits[group >> (18 - 6 * d) & 63];
  }
  return text;
}

std::string gltf_text(const std::vector<GltfPrimitive>& primitives, const nlohmann::json& node,
                      const nlohmann::json& document) {
  using nlohmann::json;
  std::vector<unsigned char> bytes;
  json views = json::array(), accessors = json::array(), list = json::array();
  const auto add = [&](const auto& values, int component, const char* type) {
    const std::size_t size = values.size() * sizeof(values[0]);
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", component},
                         {"count", values.size()},
                         {"type", type}});
    bytes.resize(bytes.size() + size);
    std::memcpy(bytes.data() + bytes.size() - size, values.data(), size);
    return accessors.size() - 1;
  };
  for (const GltfPrimitive& p : primitives) {
    json primitive = {{"mode", p.mode}};
    primitive["attributes"]["POSITION"] = add(p.positions, 5126, "VEC3");
    if (!p.normals.empty()) primitive["attributes"]["NORMAL"] = add(p.normals, 5126, "VEC3");
    if (!p.uvs.empty()) primitive["attributes"]["TEXCOORD_0"] = add(p.uvs, 5126, "VEC2");
    if (!p.indices.empty()) primitive["indices"] = add(p.indices, 5125, "SCALAR");
    if (p.material >= 0) primitive["material"] = p.material;
    list.push_back(primitive);
  }
  json result = {{"asset", {{"version", "2.0"}}},
                 {"scene", 0},
                 {"scenes", {{{"nodes", {0}}}}},
                 {"nodes", {{{"mesh", 0}}}},
                 {"meshes", {{{"primitives", list}}}},
                 {"accessors", accessors},
                 {"bufferViews", views}};
  result["buffers"] = {
      {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}}};
  result["nodes"][0].update(node);
  result.update(document);
  return result.dump();
}

}  // namespace fracture::test
