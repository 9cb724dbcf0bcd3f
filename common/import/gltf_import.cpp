#include "common/import/gltf_import.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/import/gltf_accessor.hpp"
#include "common/import/gltf_document.hpp"
#include "common/import/gltf_dropped.hpp"
#include "common/import/gltf_model.hpp"
#include "common/import/gltf_morph.hpp"
#include "common/import/mesh_builder.hpp"
#include "common/import/refused.hpp"
#include "common/import/transform.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

// -- primitives

/// Decoded once per mesh. Primitives with the same attribute accessors share wedges.
struct RawSurface {
  std::map<std::string, int> accessors;
  std::vector<MorphTarget> targets;
  std::vector<double> positions, normals, tangents;
  std::vector<std::vector<double>> uvs;
  std::vector<std::vector<double>> colors;  ///< 4 components
  std::vector<std::vector<double>> joints, weights;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> materials;
};

class MeshReader {
 public:
  MeshReader(const tinygltf::Model& model, std::size_t material_count, MeshBuilder& builder)
      : model_(model), material_count_(material_count), builder_(builder) {}

  /// `node`: the one that shows the mesh, because it may have morph weights of its own.
  std::vector<RawSurface> read(const tinygltf::Mesh& mesh, const tinygltf::Node& node) const {
    std::vector<RawSurface> surfaces;
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      if (primitive.mode < TINYGLTF_MODE_TRIANGLES || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
        continue;  // points and lines
      if (primitive.attributes.count("POSITION") == 0)
        continue;  // according to the specification, such a primitive is not drawn
      const std::vector<MorphTarget> targets = active_targets(primitive, mesh, node);
      auto it = std::find_if(surfaces.begin(), surfaces.end(), [&](const RawSurface& surface) {
        return surface.accessors == primitive.attributes && surface.targets == targets;
      });
      if (it == surfaces.end()) it = surfaces.insert(surfaces.end(), read_attributes(primitive, targets));
      std::vector<std::uint32_t> indices;
      const std::size_t vertices = it->positions.size() / 3;
      if (primitive.indices >= 0) {
        indices = read_indices(model_, primitive.indices);
        for (const std::uint32_t index : indices)
          if (index >= vertices)
            refuse(ErrorCode::kMalformedMesh,
                   "A triangle of mesh \"" + mesh.name.substr(0, 60) + "\" refers to vertex " +
                       std::to_string(index) + "; there are only " + std::to_string(vertices) + " vertices.",
                   "/accessors/" + std::to_string(primitive.indices));
      } else {
        indices.resize(vertices);
        for (std::size_t k = 0; k < vertices; ++k) indices[k] = static_cast<std::uint32_t>(k);
      }
      const auto triangles = gltf_triangles(indices, primitive.mode);
      it->triangles.insert(it->triangles.end(), triangles.begin(), triangles.end());
      const bool known =
          primitive.material >= 0 && static_cast<std::size_t>(primitive.material) < material_count_;
      it->materials.resize(it->triangles.size(),
                           known ? static_cast<std::uint32_t>(primitive.material) : kNoIndex);
    }
    return surfaces;
  }

 private:
  RawSurface read_attributes(const tinygltf::Primitive& primitive,
                             const std::vector<MorphTarget>& targets) const {
    RawSurface raw;
    raw.accessors = primitive.attributes;
    raw.targets = targets;
    raw.positions = read_accessor(model_, primitive.attributes.at("POSITION"), 3);
    const std::size_t count = raw.positions.size() / 3;
    const auto read = [&](const std::string& name, int width) -> std::vector<double> {
      const auto it = primitive.attributes.find(name);
      if (it == primitive.attributes.end()) return {};
      std::vector<double> values = read_accessor(model_, it->second, width);
      if (values.size() != count * static_cast<std::size_t>(width))
        refuse(ErrorCode::kMalformedMesh,
               "The attribute " + name + " and the attribute POSITION have different counts.",
               "/accessors/" + std::to_string(it->second) + "/count");
      return values;
    };
    raw.normals = read("NORMAL", 3);
    raw.tangents = read("TANGENT", 4);
    const auto has = [&](const std::string& name) { return primitive.attributes.count(name) > 0; };
    const auto numbered = [](const char* name, std::size_t k) { return name + std::to_string(k); };
    for (std::size_t k = 0; has(numbered("TEXCOORD_", k)); ++k)
      raw.uvs.push_back(read(numbered("TEXCOORD_", k), 2));
    for (std::size_t k = 0; has(numbered("COLOR_", k)); ++k) {
      const std::string name = numbered("COLOR_", k);
      const int width = accessor_width(model_, primitive.attributes.at(name));
      if (width != 3 && width != 4) refuse(ErrorCode::kMalformedMesh, "Colours must have 3 or 4 components.");
      const std::vector<double> values = read(name, width);
      std::vector<double> rgba(4 * count, 1.0);
      for (std::size_t v = 0; v < count; ++v)
        for (int c = 0; c < width; ++c) rgba[4 * v + c] = values[v * width + c];
      raw.colors.push_back(std::move(rgba));
    }
    for (std::size_t k = 0; has(numbered("JOINTS_", k)) && has(numbered("WEIGHTS_", k)); ++k) {
      raw.joints.push_back(read(numbered("JOINTS_", k), 4));
      raw.weights.push_back(read(numbered("WEIGHTS_", k), 4));
    }
    if (!targets.empty()) morph(raw);
    return raw;
  }

  void morph(RawSurface& raw) const {
    Remarks& remarks = builder_.remarks();
    bool moved = false;
    const auto add = [&](const std::string& attribute, std::size_t stride, std::vector<double>& values) {
      moved = add_displacements(model_, raw.targets, attribute, stride, values, remarks) || moved;
    };
    add("POSITION", 3, raw.positions);
    add("NORMAL", 3, raw.normals);
    add("TANGENT", 4, raw.tangents);
    for (std::size_t k = 0; k < raw.uvs.size(); ++k) add("TEXCOORD_" + std::to_string(k), 2, raw.uvs[k]);
    for (std::size_t k = 0; k < raw.colors.size(); ++k) add("COLOR_" + std::to_string(k), 4, raw.colors[k]);
    if (moved) remarks.note("Morph targets were applied at their default weights.");
  }

  const tinygltf::Model& model_;
  std::size_t material_count_;
  MeshBuilder& builder_;
};

// -- skins

/// One matrix per joint, which moves the mesh to the pose stored in the file (joint's world · inverse bind
/// matrix).
std::vector<Transform> joint_matrices(const tinygltf::Model& model, const GltfScene& scene,
                                      const tinygltf::Skin& skin) {
  std::vector<double> inverse;
  if (skin.inverseBindMatrices >= 0) inverse = read_accessor(model, skin.inverseBindMatrices, 16);
  std::vector<Transform> result;
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    at(model.nodes, skin.joints[j], "joint");
    const auto& world = scene.world[static_cast<std::size_t>(skin.joints[j])];
    Transform bind;
    if (inverse.size() >= 16 * (j + 1)) {
      const double* m = &inverse[16 * j];
      bind = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
    }
    result.push_back(world.value_or(Transform{}) * bind);
  }
  return result;
}

double largest_difference(const Transform& a, const Transform& b) {
  double d = 0;
  for (const auto& [u, v] : {std::pair{a.x, b.x}, {a.y, b.y}, {a.z, b.z}, {a.t, b.t}})
    for (int k = 0; k < 3; ++k) d = std::max(d, std::abs(u[k] - v[k]));
  return d;
}

/// Moves the vertices of a skinned mesh to the world. If the stored pose is the bind pose, all joints agree
/// up to the rounding of the inverse bind matrices. Then one matrix moves the whole mesh, and identical
/// vertices stay identical.
class Skinning {
 public:
  Skinning(std::vector<Transform> joints, double size) : joints_(std::move(joints)) {
    constexpr double kRounding = 1e-4;  // float32 matrices multiplied along a chain of some twenty joints
    if (joints_.empty()) return;
    for (const Transform& joint : joints_)
      if (!(largest_difference(joint, joints_[0]) <= kRounding * std::max(1.0, size))) return;
    rigid_ = joints_[0];
    if (largest_difference(*rigid_, Transform{}) <= kRounding * std::max(1.0, size)) rigid_ = Transform{};
  }
  const std::optional<Transform>& rigid() const { return rigid_; }

  Transform blend(const RawSurface& raw, std::size_t vertex) const {
    Transform sum{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    double total = 0;
    for (std::size_t set = 0; set < raw.joints.size(); ++set)
      for (std::size_t k = 0; k < 4; ++k) {
        const double weight = raw.weights[set][4 * vertex + k], joint = raw.joints[set][4 * vertex + k];
        if (!(weight > 0)) continue;
        if (!(joint < static_cast<double>(joints_.size())))
          refuse(ErrorCode::kMalformedMesh,
                 "A vertex refers to joint " + std::to_string(static_cast<std::uint64_t>(joint)) +
                     "; the skin has only " + std::to_string(joints_.size()) + " joints.");
        const Transform& m = joints_[static_cast<std::size_t>(joint)];
        sum = {sum.x + weight * m.x, sum.y + weight * m.y, sum.z + weight * m.z, sum.t + weight * m.t};
        total += weight;
      }
    if (!(total > 0)) return Transform{};
    const double scale = 1 / total;
    return {scale * sum.x, scale * sum.y, scale * sum.z, scale * sum.t};
  }

 private:
  std::vector<Transform> joints_;
  std::optional<Transform> rigid_;
};

// -- into the world

Vec3d triple(const std::vector<double>& values, std::size_t v, std::size_t width = 3) {
  return {values[width * v], values[width * v + 1], values[width * v + 2]};
}

/// Returns the surface after applying a transform to each vertex (the same for all vertices unless skinned).
/// The winding is reversed if `mirrored`.
template <class TransformOf>
Surface place(const RawSurface& raw, bool mirrored, TransformOf&& transform_of) {
  Surface surface;
  const std::size_t count = raw.positions.size() / 3;
  surface.positions.resize(count);
  surface.attributes.normals.resize(raw.normals.empty() ? 0 : count);
  surface.attributes.tangents.resize(raw.tangents.empty() ? 0 : count);
  for (std::size_t v = 0; v < count; ++v) {
    const Transform& m = transform_of(v);
    const bool identity = m == Transform{};
    const Vec3d p = triple(raw.positions, v);
    surface.positions[v] = to_float(identity ? p : m.point(p));
    if (!raw.normals.empty()) {
      const Vec3d n = triple(raw.normals, v);
      // A unit normal that is not transformed keeps its bits. Quantised normals must be normalised.
      const bool keep = identity && std::abs(dot(n, n) - 1) < 1e-6;
      surface.attributes.normals[v] = keep ? to_float(n) : unit_float(identity ? n : m.normal(n));
    }
    if (!raw.tangents.empty()) {
      const Vec3d t = triple(raw.tangents, v, 4);
      const bool keep = identity && std::abs(dot(t, t) - 1) < 1e-6;
      const Vec3f u = keep ? to_float(t) : unit_float(identity ? t : m.linear(t));
      const double sign = raw.tangents[4 * v + 3] < 0 ? -1 : 1;
      surface.attributes.tangents[v] = {u.x, u.y, u.z, static_cast<float>(mirrored ? -sign : sign)};
    }
  }
  for (const auto& set : raw.uvs) {
    auto& uvs = surface.attributes.uvs.emplace_back(count);
    for (std::size_t v = 0; v < count; ++v)
      uvs[v] = {static_cast<float>(set[2 * v]), static_cast<float>(set[2 * v + 1])};
  }
  for (const auto& set : raw.colors) {
    auto& colors = surface.attributes.colors.emplace_back(count);
    for (std::size_t v = 0; v < count; ++v) {
      const auto c = [&](std::size_t k) { return static_cast<float>(set[4 * v + k]); };
      colors[v] = {c(0), c(1), c(2), c(3)};
    }
  }
  surface.triangles = raw.triangles;
  if (mirrored)
    for (auto& triangle : surface.triangles) std::swap(triangle[1], triangle[2]);
  surface.materials = raw.materials;
  return surface;
}

double largest_coordinate(const std::vector<RawSurface>& surfaces) {
  double size = 0;
  for (const RawSurface& surface : surfaces)
    for (const double c : surface.positions) size = std::max(size, std::abs(c));
  return size;
}

void add(MeshBuilder& builder, Surface surface) {
  if (surface.triangles.empty()) return;
  if (auto added = builder.add(std::move(surface)); !added) throw Refused{added.error()};
}

/// `group`: of the nodes above. `extras`: of the node (Mesh::node_extras).
void add_node(const tinygltf::Model& model, const GltfScene& scene, int index, std::uint32_t group,
              const std::string& extras, const MeshReader& reader, MeshBuilder& builder,
              const ImportLimits& limits) {
  const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(index)];
  if (node.mesh < 0) return;
  const tinygltf::Mesh& mesh = at(model.meshes, node.mesh, "mesh");
  const std::vector<RawSurface> surfaces = reader.read(mesh, node);
  const std::string name = !node.name.empty() ? node.name : !mesh.name.empty() ? mesh.name : "mesh";
  if (name != mesh.name) group = builder.add_group(mesh.name, group);
  const bool skinned = node.skin >= 0 && std::any_of(surfaces.begin(), surfaces.end(),
                                                     [](const RawSurface& s) { return !s.joints.empty(); });
  if (skinned) {
    // A skinned mesh ignores its node's own transform (glTF 2.0, 3.7.3.3).
    const Skinning skinning(joint_matrices(model, scene, at(model.skins, node.skin, "skin")),
                            largest_coordinate(surfaces));
    builder.begin_node(name, group);
    builder.set_extras(extras);
    builder.remarks().note(
        skinning.rigid() ? "Skins were baked in the bind pose."
                         : "Skins were baked in the pose that the file stores, which is not the bind pose.");
    for (const RawSurface& raw : surfaces) {
      const bool blended = !skinning.rigid() && !raw.joints.empty();
      const Transform rigid = skinning.rigid().value_or(*scene.world[static_cast<std::size_t>(index)]);
      if (blended) {
        Transform current;
        add(builder, place(raw, false, [&](std::size_t v) -> const Transform& {
              return current = skinning.blend(raw, v);
            }));
      } else {
        add(builder,
            place(raw, rigid.determinant() < 0, [&](std::size_t) -> const Transform& { return rigid; }));
      }
    }
    return;
  }
  const Transform& world = *scene.world[static_cast<std::size_t>(index)];
  for (const Transform& instance : gltf_instances(model, node, limits.max_triangles)) {
    const Transform m = instance == Transform{} ? world : world * instance;
    builder.begin_node(name, group);
    builder.set_extras(extras);
    for (const RawSurface& raw : surfaces)
      add(builder, place(raw, m.determinant() < 0, [&](std::size_t) -> const Transform& { return m; }));
  }
}

}  // namespace

Expected<Mesh> import_gltf(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits,
                           std::span<const ImportFile> files) {
  try {
    GltfDocument document = read_gltf_document(bytes, format, limits, files);
    MeshBuilder builder(limits);
    builder.remarks().add(document.remarks);
    builder.dropped() = std::move(document.dropped);
    const std::size_t material_count = document.library.materials.size();
    builder.set_library(std::move(document.library));
    builder.set_copyright(document.copyright);
    const tinygltf::Model model = load_gltf_model(document);
    const MeshReader reader(model, material_count, builder);
    const GltfScene scene = walk_gltf_scene(model, document.center);
    OtherNodes others = other_nodes(document.json, model, scene);
    std::ranges::move(others.dropped, std::back_inserter(builder.dropped()));
    builder.set_empty_nodes(std::move(others.kept));
    std::vector<std::uint32_t> group_above(model.nodes.size(), kNoIndex);
    for (const int index : scene.order) {  // parents come before their children
      const auto at = static_cast<std::size_t>(index);
      add_node(model, scene, index, group_above[at], carried_extras(document.json["nodes"][at]), reader,
               builder, limits);
      const tinygltf::Node& node = model.nodes[at];
      if (node.children.empty()) continue;
      const std::uint32_t group = builder.add_group(node.name, group_above[at]);
      for (const int child : node.children) group_above[static_cast<std::size_t>(child)] = group;
    }
    return builder.finish();
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  } catch (const nlohmann::json::exception& error) {
    return fail(ErrorCode::kMalformedMesh,
                std::string("The glTF has a value of the wrong type: ") + error.what() + ".");
  }
}

}  // namespace fracture
