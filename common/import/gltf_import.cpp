#include "common/import/gltf_import.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/import/gltf_accessor.hpp"
#include "common/import/gltf_document.hpp"
#include "common/import/gltf_dropped.hpp"
#include "common/import/gltf_model.hpp"
#include "common/import/gltf_morph.hpp"
#include "common/import/gltf_offset.hpp"
#include "common/import/gltf_skin.hpp"
#include "common/import/mesh_builder.hpp"
#include "common/import/refused.hpp"
#include "common/import/transform.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

// -- primitives

/// Decoded once per mesh. Primitives with the same attribute accessors share wedges.
struct RawSurface {
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

  /// `node`: the one that shows the mesh, because it may have its own morph weights.
  std::vector<RawSurface> read(const tinygltf::Mesh& mesh, const tinygltf::Node& node) const {
    std::vector<RawSurface> surfaces;
    std::map<std::map<std::string, int>, std::vector<std::size_t>> by_accessors;  // indices of surfaces
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      if (primitive.mode < TINYGLTF_MODE_TRIANGLES || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
        continue;  // points and lines
      if (primitive.attributes.count("POSITION") == 0)
        continue;  // according to the specification, such a primitive is not drawn
      const std::vector<MorphTarget> targets = active_targets(primitive, mesh, node);
      std::vector<std::size_t>& alike = by_accessors[primitive.attributes];
      const auto same = std::find_if(alike.begin(), alike.end(),
                                     [&](std::size_t k) { return surfaces[k].targets == targets; });
      const std::size_t which = same == alike.end() ? surfaces.size() : *same;
      if (which == surfaces.size()) {
        surfaces.push_back(read_attributes(primitive, targets));
        alike.push_back(which);
      }
      RawSurface* const it = &surfaces[which];
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
    raw.targets = targets;
    raw.positions = read_accessor(model_, primitive.attributes.at("POSITION"), 3);
    const std::size_t count = raw.positions.size() / 3;
    const auto read = [&](const std::string& name, int width) -> std::vector<double> {
      const auto it = primitive.attributes.find(name);
      if (it == primitive.attributes.end()) return {};
      std::vector<double> values = read_accessor(model_, it->second, width);
      if (values.size() != count * static_cast<std::size_t>(width))
        refuse(ErrorCode::kMalformedMesh, "The attributes " + name + " and POSITION have different counts.",
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

// -- into the world

Vec3d triple(const std::vector<double>& values, std::size_t v, std::size_t width = 3) {
  return {values[width * v], values[width * v + 1], values[width * v + 2]};
}

/// Returns the surface after applying a transform to each vertex (the same for all vertices unless skinned). If the
/// transform mirrors, tangents change their handedness. A triangle is reversed if most of its corners are mirrored, so
/// its winding still agrees with its normals.
template <class TransformOf, class IsMirrored>
Surface place(const RawSurface& raw, IsMirrored&& is_mirrored, TransformOf&& transform_of) {
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
      const double sign = (raw.tangents[4 * v + 3] < 0) == is_mirrored(v) ? 1 : -1;
      surface.attributes.tangents[v] = {u.x, u.y, u.z, static_cast<float>(sign)};
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
  for (auto& triangle : surface.triangles) {
    const auto mirrored = std::count_if(triangle.begin(), triangle.end(), is_mirrored);
    if (mirrored >= 2) std::swap(triangle[1], triangle[2]);
  }
  surface.materials = raw.materials;
  return surface;
}

Surface place(const RawSurface& raw, const Transform& transform) {
  const bool mirrored = transform.determinant() < 0;
  return place(
      raw, [&](std::size_t) { return mirrored; }, [&](std::size_t) -> const Transform& { return transform; });
}

Surface blend(const RawSurface& raw, const Skinning& skinning) {
  std::vector<Transform> of_vertex(raw.positions.size() / 3);
  for (std::size_t v = 0; v < of_vertex.size(); ++v)
    of_vertex[v] = skinning.blend(raw.joints, raw.weights, v);
  return place(
      raw, [&](std::size_t v) { return of_vertex[v].determinant() < 0; },
      [&](std::size_t v) -> const Transform& { return of_vertex[v]; });
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

/// Adds a node with a mesh. `group`: of the nodes above. `above`: number of the source's node above it in the tree; becomes its
/// own. `offset`: what was subtracted from the scene. `extras`: of the node (Mesh::node_extras).
void add_node(const tinygltf::Model& model, const GltfScene& scene, const Vec3d& offset, int index,
              std::uint32_t group, std::uint32_t& above, const std::string& extras, const MeshReader& reader,
              MeshBuilder& builder, const ImportLimits& limits) {
  const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(index)];
  const tinygltf::Mesh& mesh = at(model.meshes, node.mesh, "mesh");
  const std::vector<RawSurface> surfaces = reader.read(mesh, node);
  const std::string name = !node.name.empty() ? node.name : !mesh.name.empty() ? mesh.name : "mesh";
  if (name != mesh.name) group = builder.add_group(mesh.name, group);
  above = builder.add_source_node(name, above);
  const bool skinned = node.skin >= 0 && std::any_of(surfaces.begin(), surfaces.end(),
                                                     [](const RawSurface& s) { return !s.joints.empty(); });
  if (skinned) {
    // A skinned mesh ignores its node's own transform (glTF 2.0, 3.7.3.3).
    const Skinning skinning(joint_matrices(model, scene, at(model.skins, node.skin, "skin"), offset),
                            largest_coordinate(surfaces), offset);
    builder.begin_node(name, group);
    builder.set_source_node(above);
    builder.set_extras(extras);
    builder.remarks().note(
        skinning.rigid() ? "Skins were baked in the bind pose."
                         : "Skins were baked in the pose that the file stores, which is not the bind pose.");
    for (const RawSurface& raw : surfaces) {
      const Transform rigid = skinning.rigid().value_or(*scene.world[static_cast<std::size_t>(index)]);
      add(builder, skinning.rigid() || raw.joints.empty() ? place(raw, rigid) : blend(raw, skinning));
    }
    return;
  }
  const Transform& world = *scene.world[static_cast<std::size_t>(index)];
  // Morph weights of its own may give the node another shape than those that share its mesh.
  const std::uint32_t shared = node.weights.empty() ? static_cast<std::uint32_t>(node.mesh) : kNoIndex;
  for (const Transform& instance : gltf_instances(model, node, limits.max_triangles)) {
    const Transform m = instance == Transform{} ? world : world * instance;
    builder.begin_node(name, group, {shared, m.x, m.y, m.z, m.t});
    builder.set_source_node(above);
    builder.set_extras(extras);
    for (const RawSurface& raw : surfaces) add(builder, place(raw, m));
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
    GltfScene scene = walk_gltf_scene(model, document.center);
    const Vec3d offset = gltf_offset(model, scene, limits.max_triangles);
    subtract(offset, scene);
    OtherNodes others = other_nodes(document.json, model, scene);
    std::ranges::move(others.dropped, std::back_inserter(builder.dropped()));
    builder.set_empty_nodes(std::move(others.kept));
    std::vector<std::uint32_t> group_above(model.nodes.size(), kNoIndex), above = group_above;
    for (const int index : scene.order) {  // parents come before their children
      const auto at = static_cast<std::size_t>(index);
      const tinygltf::Node& node = model.nodes[at];
      const std::string extras = carried_extras(document.json["nodes"][at]);
      if (node.mesh >= 0)
        add_node(model, scene, offset, index, group_above[at], above[at], extras, reader, builder, limits);
      else
        above[at] = builder.add_source_node(node.name, above[at], extras);
      if (node.children.empty()) continue;
      const std::uint32_t group = builder.add_group(node.name, group_above[at]);
      for (const int child : node.children) {
        group_above[static_cast<std::size_t>(child)] = group;
        above[static_cast<std::size_t>(child)] = above[at];
      }
    }
    Expected<Mesh> mesh = builder.finish();
    if (mesh) mesh->frame.offset = offset;
    return mesh;
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  } catch (const nlohmann::json::exception& error) {
    return fail(ErrorCode::kMalformedMesh,
                std::string("The glTF has a value of the wrong type: ") + error.what() + ".");
  }
}

}  // namespace fracture
