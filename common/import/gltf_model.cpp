#include "common/import/gltf_model.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "common/base/words.hpp"
#include "common/import/gltf_accessor.hpp"
#include "common/import/refused.hpp"

namespace fracture {
namespace {

// -- loading

bool no_file_exists(const std::string&, void*) { return false; }
std::string no_path(const std::string&, void*) { return {}; }
bool read_nothing(std::vector<unsigned char>*, std::string*, const std::string&, void*) { return false; }
bool write_nothing(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
  return false;
}
bool keep_no_image(tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*,
                   int, void*) {
  return true;
}

void put_u32(std::vector<unsigned char>& out, std::uint64_t value) {
  for (int k = 0; k < 4; ++k) out.push_back(static_cast<unsigned char>(value >> 8 * k & 0xff));
}

Transform local_transform(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) {
    const std::vector<double>& m = node.matrix;  // column-major
    return {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
  }
  const auto vector = [](const std::vector<double>& v, double fallback) {
    return v.size() == 3 ? Vec3d{v[0], v[1], v[2]} : Vec3d{fallback, fallback, fallback};
  };
  std::array<double, 4> q{0, 0, 0, 1};
  if (node.rotation.size() == 4) std::copy(node.rotation.begin(), node.rotation.end(), q.begin());
  return compose(vector(node.translation, 0), q, vector(node.scale, 1));
}

/// KHR_node_visibility: nodes are visible unless they say otherwise.
bool is_visible(const tinygltf::Node& node) {
  const auto extension = node.extensions.find("KHR_node_visibility");
  if (extension == node.extensions.end() || !extension->second.IsObject()) return true;
  const tinygltf::Value& visible = extension->second.Get("visible");
  return !visible.IsBool() || visible.Get<bool>();
}

}  // namespace

tinygltf::Model load_gltf_model(GltfDocument& document) {
  std::string json = document.json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::vector<unsigned char> glb;
  glb.reserve(28 + json.size() + document.binary.size());
  put_u32(glb, 0x46546c67);
  put_u32(glb, 2);
  put_u32(glb, 28 + json.size() + document.binary.size());
  put_u32(glb, json.size());
  put_u32(glb, 0x4e4f534a);
  glb.insert(glb.end(), json.begin(), json.end());
  put_u32(glb, document.binary.size());
  put_u32(glb, 0x004e4942);
  glb.insert(glb.end(), document.binary.begin(), document.binary.end());
  document.binary = {};

  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks({no_file_exists, no_path, read_nothing, write_nothing, nullptr});
  loader.SetImageLoader(keep_no_image, nullptr);
  tinygltf::Model model;
  std::string errors, warnings;
  if (!loader.LoadBinaryFromMemory(&model, &errors, &warnings, glb.data(), static_cast<unsigned>(glb.size()),
                                   "", 0)) {
    while (!errors.empty() && (errors.back() == '\n' || errors.back() == ' ')) errors.pop_back();
    refuse(ErrorCode::kMalformedMesh, "The glTF cannot be read: " + errors.substr(0, 300) +
                                          (errors.ends_with('.') ? "" : ".") + " Export it again.");
  }
  return model;
}

GltfScene walk_gltf_scene(const tinygltf::Model& model, const Vec3d& center) {
  GltfScene scene;
  scene.world.resize(model.nodes.size());
  std::vector<int> roots;
  if (!model.scenes.empty()) {
    roots = at(model.scenes, std::max(model.defaultScene, 0), "scene").nodes;
  } else {
    std::vector<bool> child(model.nodes.size(), false);
    for (const auto& node : model.nodes)
      for (const int c : node.children)
        if (c >= 0 && static_cast<std::size_t>(c) < child.size()) child[static_cast<std::size_t>(c)] = true;
    for (std::size_t n = 0; n < child.size(); ++n)
      if (!child[n]) roots.push_back(static_cast<int>(n));
  }
  struct Waiting {
    int node;
    Transform parent;
    bool is_hidden;
  };
  Transform origin;
  origin.t = center;
  std::vector<Waiting> stack;
  for (auto it = roots.rbegin(); it != roots.rend(); ++it) stack.push_back({*it, origin, false});
  while (!stack.empty()) {
    const auto [index, parent, above_is_hidden] = stack.back();
    stack.pop_back();
    const tinygltf::Node& node = at(model.nodes, index, "node");
    auto& world = scene.world[static_cast<std::size_t>(index)];
    if (world)
      refuse(ErrorCode::kMalformedMesh,
             "Node " + std::to_string(index) + " is reached twice, so the nodes do not form a tree.",
             "/nodes/" + std::to_string(index));
    const Transform local = local_transform(node);
    world = parent == Transform{} ? local : local == Transform{} ? parent : parent * local;
    const bool is_hidden = above_is_hidden || !is_visible(node);
    (is_hidden ? scene.hidden : scene.order).push_back(index);
    for (auto it = node.children.rbegin(); it != node.children.rend(); ++it)
      stack.push_back({*it, *world, is_hidden});
  }
  return scene;
}

std::vector<Transform> gltf_instances(const tinygltf::Model& model, const tinygltf::Node& node,
                                      std::uint64_t max_instances) {
  const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
  if (extension == node.extensions.end() || !extension->second.IsObject()) return {Transform{}};
  const tinygltf::Value& attributes = extension->second.Get("attributes");
  const auto read = [&](const char* name, int width) -> std::vector<double> {
    if (!attributes.IsObject() || !attributes.Has(name) || !attributes.Get(name).IsInt()) return {};
    return read_accessor(model, attributes.Get(name).GetNumberAsInt(), width);
  };
  const std::vector<double> t = read("TRANSLATION", 3), r = read("ROTATION", 4), s = read("SCALE", 3);
  const std::size_t count = std::max({t.size() / 3, r.size() / 4, s.size() / 3});
  if (count == 0) return {Transform{}};
  if ((!t.empty() && t.size() != 3 * count) || (!r.empty() && r.size() != 4 * count) ||
      (!s.empty() && s.size() != 3 * count))
    refuse(ErrorCode::kMalformedMesh, "The attributes of EXT_mesh_gpu_instancing have different counts.");
  if (count > max_instances)
    refuse(ErrorCode::kTooLarge, "EXT_mesh_gpu_instancing makes " + grouped(count) +
                                     " instances; the limit is " + grouped(max_instances) +
                                     ". Divide the scene into several files.");
  std::vector<Transform> result(count);
  for (std::size_t k = 0; k < count; ++k)
    result[k] = compose(t.empty() ? Vec3d{} : Vec3d{t[3 * k], t[3 * k + 1], t[3 * k + 2]},
                        r.empty() ? std::array<double, 4>{0, 0, 0, 1}
                                  : std::array{r[4 * k], r[4 * k + 1], r[4 * k + 2], r[4 * k + 3]},
                        s.empty() ? Vec3d{1, 1, 1} : Vec3d{s[3 * k], s[3 * k + 1], s[3 * k + 2]});
  return result;
}

std::vector<std::array<std::uint32_t, 3>> gltf_triangles(const std::vector<std::uint32_t>& i, int mode) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    for (std::size_t k = 0; k + 2 < i.size(); k += 3) triangles.push_back({i[k], i[k + 1], i[k + 2]});
    return triangles;
  }
  for (std::size_t k = 0; k + 2 < i.size(); ++k) {
    std::array<std::uint32_t, 3> triangle{};
    if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
      triangle = {i[k + 1], i[k + 2], i[0]};
    else
      triangle = k % 2 == 0 ? std::array{i[k], i[k + 1], i[k + 2]} : std::array{i[k], i[k + 2], i[k + 1]};
    // Strips are joined by triangles that use a vertex twice.
    if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
      triangles.push_back(triangle);
  }
  return triangles;
}

}  // namespace fracture
