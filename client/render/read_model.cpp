#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>

#include "client/render/model.hpp"
#include "client/render/read_materials.hpp"
#include "common/import/gltf_accessor.hpp"
#include "common/import/gltf_document.hpp"
#include "common/import/gltf_model.hpp"
#include "common/import/gltf_offset.hpp"
#include "common/import/refused.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture::render {
namespace {

using nlohmann::json;

glm::vec3 to_vec3(const Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

glm::mat4 to_mat4(const Transform& t) {
  return {glm::vec4(to_vec3(t.x), 0), glm::vec4(to_vec3(t.y), 0), glm::vec4(to_vec3(t.z), 0),
          glm::vec4(to_vec3(t.t), 1)};
}

/// A node's extras.fracture in the document's JSON, or null.
const json* fracture_extras(const json& document, int node) {
  const json& nodes = document.at("nodes");
  const json& object = nodes.at(static_cast<std::size_t>(node));
  const auto extras = object.find("extras");
  if (extras == object.end() || !extras->is_object()) return nullptr;
  const auto fracture = extras->find("fracture");
  return fracture != extras->end() && fracture->is_object() ? &*fracture : nullptr;
}

class ModelReader {
 public:
  ModelReader(const json& nodes_document, const tinygltf::Model& gltf, const ImportLimits& limits,
              Model& model)
      : document_(nodes_document), gltf_(gltf), limits_(limits), model_(model) {}

  void read(Placed placed) {
    GltfScene graph = walk_gltf_scene(gltf_);
    if (placed == Placed::kNearOrigin) subtract(gltf_offset(gltf_, graph, limits_.max_triangles), graph);
    std::vector<int> parents(gltf_.nodes.size(), -1);
    for (std::size_t n = 0; n < gltf_.nodes.size(); ++n)
      for (const int child : gltf_.nodes[n].children)
        if (child >= 0 && static_cast<std::size_t>(child) < parents.size())
          parents[static_cast<std::size_t>(child)] = static_cast<int>(n);
    for (const int index : graph.order) {
      const json* extras = fracture_extras(document_, index);
      if (extras != nullptr) mark_interior(*extras);
      if (extras != nullptr && extras->contains("certificate"))
        root_ = to_vec3(graph.world[static_cast<std::size_t>(index)]->t);
      const tinygltf::Node& node = gltf_.nodes[static_cast<std::size_t>(index)];
      if (node.mesh < 0 || node.name.starts_with("UCX_") ||
          is_sheet(index, parents[static_cast<std::size_t>(index)]))
        continue;
      const Transform& world = *graph.world[static_cast<std::size_t>(index)];
      for (const Transform& instance : gltf_instances(gltf_, node, limits_.max_triangles))
        read_object(node, world * instance, fragment_info(index, extras, parents));
    }
    sort_surfaces();
  }

 private:
  /// Whether a node has the sheets that a fragment, its parent (-1: none), carries. They are drawn as part of the fragment.
  bool is_sheet(int index, int parent) const {
    const tinygltf::Node& node = gltf_.nodes[static_cast<std::size_t>(index)];
    if (parent < 0 || node.mesh < 0 || node.name.starts_with("UCX_")) return false;
    if (!node.matrix.empty() || !node.translation.empty() || !node.rotation.empty() || !node.scale.empty())
      return false;
    const json *own = fracture_extras(document_, index), *above = fracture_extras(document_, parent);
    return own == nullptr && above != nullptr && above->contains("id") &&
           gltf_.nodes[static_cast<std::size_t>(parent)].mesh >= 0;
  }

  /// The root's extras list the materials of cut faces. Before algorithm 11, it was the last material.
  void mark_interior(const json& extras) {
    const auto listed = extras.find("interior_materials");
    if (listed == extras.end() && extras.contains("certificate") && model_.materials.size() > 1)
      model_.materials[model_.materials.size() - 2].interior = true;
    if (listed == extras.end() || !listed->is_array()) return;
    for (const json& index : *listed)
      if (index.is_number_unsigned() && index.get<std::size_t>() < model_.materials.size())
        model_.materials[index.get<std::size_t>()].interior = true;
  }

  std::optional<FragmentInfo> fragment_info(int node, const json* extras,
                                            const std::vector<int>& parents) const {
    if (extras == nullptr || !extras->contains("id")) return std::nullopt;
    FragmentInfo info;
    info.id = extras->at("id").get<std::uint64_t>();
    info.volume = extras->value("volume", 0.0);
    info.anchored = extras->value("anchored", false);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    info.centroid = glm::vec3(nan);
    if (const auto it = extras->find("center_of_mass");
        it != extras->end() && it->is_array() && it->size() == 3)
      for (int k = 0; k < 3; ++k)
        info.centroid[k] = (*it)[static_cast<std::size_t>(k)].get<float>() + root_[k];
    for (int n = node; n >= 0; n = parents[static_cast<std::size_t>(n)])
      if (const json* own = fracture_extras(document_, n); own != nullptr && own->contains("level"))
        info.ancestors.insert(info.ancestors.begin(), static_cast<std::uint32_t>(n));
    if (info.ancestors.empty()) info.ancestors.push_back(static_cast<std::uint32_t>(node));
    return info;
  }

  void read_object(const tinygltf::Node& node, const Transform& world, std::optional<FragmentInfo> fragment) {
    if (node.skin >= 0) warn("Skins are shown in their bind pose.");
    const auto number = static_cast<std::uint32_t>(model_.objects.size());
    Object object;
    object.name = node.name;
    object.transform = to_mat4(world);
    shared_.clear();
    const std::size_t first_vertex = model_.vertices.size(), first_surface = model_.surfaces.size();
    if (static_cast<std::size_t>(node.mesh) >= gltf_.meshes.size())
      refuse(ErrorCode::kMalformedMesh, "Mesh " + std::to_string(node.mesh) + " does not exist.");
    for (const tinygltf::Primitive& p : gltf_.meshes[static_cast<std::size_t>(node.mesh)].primitives)
      read_primitive(p, number, world.determinant() < 0);
    if (fragment) read_sheets(node, number, world.determinant() < 0);
    if (model_.surfaces.size() == first_surface) {
      model_.vertices.resize(first_vertex);
      return;
    }

    glm::vec3 low(HUGE_VALF), high(-HUGE_VALF);
    for (std::size_t v = first_vertex; v < model_.vertices.size(); ++v) {
      low = glm::min(low, model_.vertices[v].position);
      high = glm::max(high, model_.vertices[v].position);
    }
    object.bounds.center = 0.5f * (low + high);
    for (std::size_t v = first_vertex; v < model_.vertices.size(); ++v)
      object.bounds.radius =
          std::max(object.bounds.radius, glm::distance(object.bounds.center, model_.vertices[v].position));
    if (fragment && !(std::isfinite(fragment->centroid.x + fragment->centroid.y + fragment->centroid.z)))
      fragment->centroid = glm::vec3(object.transform * glm::vec4(object.bounds.center, 1));
    object.fragment = std::move(fragment);
    model_.objects.push_back(std::move(object));
  }

  /// Reads the sheets that a fragment carries, as surfaces of the same object.
  void read_sheets(const tinygltf::Node& fragment, std::uint32_t number, bool mirrored) {
    const int parent = static_cast<int>(&fragment - gltf_.nodes.data());
    for (const int child : fragment.children) {
      if (!is_sheet(child, parent)) continue;
      const int mesh = gltf_.nodes[static_cast<std::size_t>(child)].mesh;
      if (static_cast<std::size_t>(mesh) >= gltf_.meshes.size())
        refuse(ErrorCode::kMalformedMesh, "Mesh " + std::to_string(mesh) + " does not exist.");
      shared_.clear();
      for (const tinygltf::Primitive& p : gltf_.meshes[static_cast<std::size_t>(mesh)].primitives)
        read_primitive(p, number, mirrored);
    }
  }

  void read_primitive(const tinygltf::Primitive& primitive, std::uint32_t object, bool mirrored) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return;  // glTF 2.0, 3.7.2.1: such a primitive is not drawn
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
      warn("Points and lines are not drawn.");
      return;
    }
    if (!primitive.targets.empty()) warn("Morph targets are not applied.");
    auto [shared, first_use] = shared_.try_emplace(primitive.attributes, 0u, 0u);
    if (first_use) shared->second = append_vertices(primitive, object);
    const auto [base, count] = shared->second;

    std::vector<std::uint32_t> indices(count);
    if (primitive.indices >= 0) {
      indices = read_indices(gltf_, primitive.indices);
    } else {
      for (std::uint32_t k = 0; k < count; ++k) indices[k] = k;
    }
    for (const std::uint32_t index : indices)
      if (index >= count)
        refuse(ErrorCode::kMalformedMesh, "A triangle of mesh \"" + name_of(object) + "\" refers to vertex " +
                                              std::to_string(index) + ", but there are " +
                                              std::to_string(count) + ".");
    std::vector<std::array<std::uint32_t, 3>> triangles = gltf_triangles(indices, primitive.mode);
    if (model_.indices.size() / 3 + triangles.size() > limits_.max_triangles)
      refuse(ErrorCode::kTooLarge,
             "The model has more than " + std::to_string(limits_.max_triangles) + " triangles.");
    if (triangles.empty()) return;
    if (mirrored)
      for (auto& t : triangles) std::swap(t[1], t[2]);

    Surface surface;
    surface.object = object;
    surface.material =
        primitive.material >= 0 && static_cast<std::size_t>(primitive.material) + 1 < model_.materials.size()
            ? static_cast<std::uint32_t>(primitive.material)
            : static_cast<std::uint32_t>(model_.materials.size() - 1);
    surface.first_index = static_cast<std::uint32_t>(model_.indices.size());
    surface.index_count = static_cast<std::uint32_t>(3 * triangles.size());
    if (primitive.attributes.count("NORMAL") > 0) {
      for (const auto& t : triangles)
        for (const std::uint32_t v : t) model_.indices.push_back(base + v);
    } else {
      append_flat(triangles, base, mirrored);
    }
    model_.surfaces.push_back(surface);
  }

  /// Appends the vertices of a set of accessors, once per object. Returns the first one's index and their
  /// number.
  std::pair<std::uint32_t, std::uint32_t> append_vertices(const tinygltf::Primitive& primitive,
                                                          std::uint32_t object) {
    const auto base = static_cast<std::uint32_t>(model_.vertices.size());
    const std::vector<double> positions = read_accessor(gltf_, primitive.attributes.at("POSITION"), 3);
    const std::size_t count = positions.size() / 3;
    if (model_.vertices.size() + count > 3 * limits_.max_triangles)
      refuse(ErrorCode::kTooLarge,
             "The model has more than " + std::to_string(3 * limits_.max_triangles) + " vertices.");
    model_.vertices.resize(base + count);
    const auto each = [&](const std::string& name, int width, auto&& store) {
      const auto it = primitive.attributes.find(name);
      if (it == primitive.attributes.end()) return;
      const std::vector<double> values = read_accessor(gltf_, it->second, width);
      if (values.size() != count * static_cast<std::size_t>(width))
        refuse(ErrorCode::kMalformedMesh,
               "The attribute " + name + " does not have as many elements as POSITION.");
      for (std::size_t v = 0; v < count; ++v) {
        std::array<float, 4> x{0, 0, 0, 1};
        for (int c = 0; c < width; ++c) {
          const double value = values[v * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)];
          if (!std::isfinite(static_cast<float>(value)))
            refuse(ErrorCode::kNotFinite, name + " of vertex " + std::to_string(v) + " of \"" +
                                              name_of(object) + "\" is not a finite number.");
          x[static_cast<std::size_t>(c)] = static_cast<float>(value);
        }
        store(model_.vertices[base + v], x);
      }
    };
    using Four = std::array<float, 4>;
    const auto unit = [](glm::vec3 n) { return glm::dot(n, n) > 0 ? glm::normalize(n) : glm::vec3(0, 1, 0); };
    each("POSITION", 3, [](Vertex& v, const Four& x) { v.position = {x[0], x[1], x[2]}; });
    each("NORMAL", 3, [&](Vertex& v, const Four& x) { v.normal = unit({x[0], x[1], x[2]}); });
    each("TANGENT", 4, [&](Vertex& v, const Four& x) {
      v.tangent = glm::vec4(unit({x[0], x[1], x[2]}), x[3] < 0 ? -1.f : 1.f);
    });
    for (int set = 0; set < 2; ++set)
      each("TEXCOORD_" + std::to_string(set), 2, [&](Vertex& v, const Four& x) { v.uv[set] = {x[0], x[1]}; });
    if (const auto it = primitive.attributes.find("COLOR_0"); it != primitive.attributes.end())
      each("COLOR_0", std::clamp(accessor_width(gltf_, it->second), 3, 4), [](Vertex& v, const Four& x) {
        for (int c = 0; c < 4; ++c)
          v.color[c] = static_cast<std::uint8_t>(
              std::lround(255 * std::clamp(x[static_cast<std::size_t>(c)], 0.f, 1.f)));
      });
    for (std::size_t v = base; v < model_.vertices.size(); ++v) model_.vertices[v].object = object;
    return {base, static_cast<std::uint32_t>(count)};
  }

  /// glTF 2.0, 3.7.2.1: without normals, triangles are shown flat. Every corner gets its own vertex.
  void append_flat(const std::vector<std::array<std::uint32_t, 3>>& triangles, std::uint32_t base,
                   bool mirrored) {
    if (model_.vertices.size() + 3 * triangles.size() > 6 * limits_.max_triangles)
      refuse(ErrorCode::kTooLarge,
             "The triangles without normals need too many vertices; the model can have at most " +
                 std::to_string(6 * limits_.max_triangles) + ".");
    for (const auto& t : triangles) {
      std::array<Vertex, 3> corner;
      for (std::size_t k = 0; k < 3; ++k) corner[k] = model_.vertices[base + t[k]];
      glm::vec3 n =
          glm::cross(corner[1].position - corner[0].position, corner[2].position - corner[0].position);
      if (mirrored) n = -n;  // in the object's own frame, the winding has been reversed
      n = glm::dot(n, n) > 0 ? glm::normalize(n) : glm::vec3(0, 1, 0);
      for (Vertex& v : corner) {
        v.normal = n;
        model_.indices.push_back(static_cast<std::uint32_t>(model_.vertices.size()));
        model_.vertices.push_back(v);
      }
    }
  }

  /// Sorts surfaces by material and reorders the indices to match, so that neighbours can share a draw call.
  void sort_surfaces() {
    std::stable_sort(model_.surfaces.begin(), model_.surfaces.end(),
                     [](const Surface& a, const Surface& b) { return a.material < b.material; });
    std::vector<std::uint32_t> sorted;
    sorted.reserve(model_.indices.size());
    for (Surface& s : model_.surfaces) {
      const auto from = model_.indices.begin() + s.first_index;
      s.first_index = static_cast<std::uint32_t>(sorted.size());
      sorted.insert(sorted.end(), from, from + s.index_count);
    }
    model_.indices = std::move(sorted);
  }

  std::string name_of(std::uint32_t object) const { return "object " + std::to_string(object); }
  void warn(const std::string& text) {
    if (std::find(model_.warnings.begin(), model_.warnings.end(), text) == model_.warnings.end())
      model_.warnings.push_back(text);
  }

  const json& document_;
  const tinygltf::Model& gltf_;
  const ImportLimits& limits_;
  Model& model_;
  glm::vec3 root_{0};  ///< place of the answer's root node; places in extras are below it
  std::map<std::map<std::string, int>, std::pair<std::uint32_t, std::uint32_t>>
      shared_;  ///< of the current object
};

}  // namespace

Expected<Model> read_model(std::span<const std::byte> bytes, Placed placed) {
  const bool binary = bytes.size() >= 4 && bytes[0] == std::byte{'g'} && bytes[1] == std::byte{'l'} &&
                      bytes[2] == std::byte{'T'} && bytes[3] == std::byte{'F'};
  try {
    const ImportLimits limits;
    GltfDocument document =
        read_gltf_document(bytes, binary ? MeshFormat::kGlb : MeshFormat::kGltf, limits, {});
    Model model;
    for (std::vector<std::string>* list : {&document.remarks.warnings, &document.remarks.notes})
      std::ranges::move(*list, std::back_inserter(model.warnings));
    read_materials(document.library, model);
    if (!document.json.contains("nodes")) refuse(ErrorCode::kEmptyMesh, "The glTF has no nodes.", "/nodes");
    const tinygltf::Model gltf = load_gltf_model(document);
    ModelReader(document.json, gltf, limits, model).read(placed);
    if (model.surfaces.empty())
      refuse(ErrorCode::kEmptyMesh, "The glTF's default scene contains no triangles.");
    return model;
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  } catch (const json::exception& error) {
    return fail(ErrorCode::kMalformedMesh,
                std::string("The glTF has a value of the wrong type: ") + error.what() + ".");
  }
}

Expected<Model> load_model(const std::string& path) {
  if (std::error_code error; std::filesystem::is_directory(path, error))  // reading it throws
    return fail(ErrorCode::kFileAccess, "Cannot read " + path + ": it is a folder.");
  std::ifstream in(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in.is_open() || in.bad()) return fail(ErrorCode::kFileAccess, "Cannot read " + path + ".");
  Expected<Model> model = read_model(std::as_bytes(std::span(bytes)), Placed::kNearOrigin);
  if (!model) return fail(model.error().code, path + ": " + to_string(model.error()));
  return model;
}

std::vector<ObjectState> initial_states(const Model& model) {
  std::vector<ObjectState> states(model.objects.size());
  for (std::size_t k = 0; k < states.size(); ++k) states[k].transform = model.objects[k].transform;
  return states;
}

Sphere bounding_sphere(const Model& model, std::span<const ObjectState> states) {
  glm::vec3 low(HUGE_VALF), high(-HUGE_VALF);
  const auto each = [&](auto&& use) {
    for (const Vertex& v : model.vertices) {
      if (!states.empty() && !states[v.object].visible) continue;
      const glm::mat4& m = states.empty() ? model.objects[v.object].transform : states[v.object].transform;
      use(glm::vec3(m * glm::vec4(v.position, 1)));
    }
  };
  each([&](const glm::vec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  });
  if (!(low.x <= high.x)) return {};
  Sphere sphere{0.5f * (low + high), 0};
  each([&](const glm::vec3& p) { sphere.radius = std::max(sphere.radius, glm::distance(sphere.center, p)); });
  return sphere;
}

}  // namespace fracture::render
