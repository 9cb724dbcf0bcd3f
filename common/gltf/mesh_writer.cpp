#include "common/gltf/mesh_writer.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/gltf/mesh_manifold.hpp"
#include "common/mesh/gltf_component.hpp"
#include "common/solid/solid.hpp"

namespace fracture {
namespace {

/// Does the material (or one of its extensions) have a normal map? Only those need tangents.
bool has_normal_texture(const nlohmann::json& value, Pacer& pacer) {
  if (!value.is_object()) return false;
  pacer.step(8);
  for (const auto& [key, child] : value.items()) {
    if (key == "extras") continue;
    if (key == "normalTexture" || key == "clearcoatNormalTexture" || has_normal_texture(child, pacer))
      return true;
  }
  return false;
}

}  // namespace

MeshWriter::MeshWriter(const MaterialLibrary& library, const nlohmann::json& interior_material,
                       bool mesh_manifold, Accessors& accessors)
    : accessors_(accessors), mesh_manifold_(mesh_manifold), interior_(library.materials.size()) {
  Pacer pacer(accessors.execution());
  for (const auto& material : library.materials)
    normal_mapped_.push_back(has_normal_texture(material, pacer));
  normal_mapped_.push_back(has_normal_texture(interior_material, pacer));
}

bool MeshWriter::needs_tangents(const FragmentPrimitive& p) const {
  const std::size_t material = p.material == kInteriorMaterial ? interior_ : p.material;
  return material < normal_mapped_.size() && normal_mapped_[material];
}

std::size_t MeshWriter::write_positions(const std::vector<Vec3f>& positions) {
  const std::size_t view = accessors_.view("POSITION", sizeof(Vec3f), kArrayBuffer);
  const std::size_t at = accessors_.bytes(view).size();
  Vec3f min, max;
  append_positions(accessors_.bytes(view), positions, min, max);
  return accessors_.add(view, at, component_type::kFloat, positions.size(), "VEC3", &min, &max);
}

void MeshWriter::write(JsonText& json, const Fragment& f, const std::string& name) {
  const bool tangents =
      !f.attributes.tangents.empty() &&
      std::any_of(f.primitives.begin(), f.primitives.end(), [&](const auto& p) { return needs_tangents(p); });
  attributes_.clear();
  const std::size_t count = f.positions.size();
  attributes_.emplace_back("POSITION", write_positions(f.positions));
  const auto attribute = [&](const std::string& semantic, int stride, const char* type, auto&& append) {
    const std::size_t view = accessors_.view(semantic, stride, kArrayBuffer);
    const std::size_t at = accessors_.bytes(view).size();
    append(accessors_.bytes(view));
    attributes_.emplace_back(semantic, accessors_.add(view, at, component_type::kFloat, count, type));
  };
  if (!f.attributes.normals.empty())
    attribute("NORMAL", sizeof(Vec3f), "VEC3", [&](ViewBytes& view) { append_normals(view, f); });
  for (std::size_t set = 0; set < f.attributes.uvs.size(); ++set)
    attribute("TEXCOORD_" + std::to_string(set), sizeof(Vec2f), "VEC2",
              [&](ViewBytes& view) { append_uvs(view, f.attributes.uvs[set]); });
  for (std::size_t set = 0; set < f.attributes.colors.size(); ++set)
    attribute("COLOR_" + std::to_string(set), sizeof(Vec4f), "VEC4",
              [&](ViewBytes& view) { append_colors(view, f.attributes.colors[set]); });
  if (tangents)
    attribute("TANGENT", sizeof(Vec4f), "VEC4", [&](ViewBytes& view) { append_tangents(view, f); });

  const bool wide = count > kMaxShortVertices;
  const std::size_t index_view = accessors_.view(wide ? "indices32" : "indices16", 0, kElementArrayBuffer);
  const std::size_t indices_at =
      append_indices(accessors_.bytes(index_view), f.indices.data(), f.indices.size(), wide);

  json.begin_object().member("name", name).key("primitives").begin_array();
  for (const FragmentPrimitive& p : f.primitives) {
    const std::size_t bytes = wide ? 4 : 2;
    json.begin_object().key("attributes").begin_object();
    for (const auto& [semantic, accessor] : attributes_)
      if (semantic != "TANGENT" || needs_tangents(p)) json.member(semantic, accessor);
    json.end_object();
    json.member("indices",
                accessors_.add(index_view, indices_at + bytes * p.first_index,
                               wide ? component_type::kUnsignedInt : component_type::kUnsignedShort,
                               p.index_count, "SCALAR"));
    if (p.material == kInteriorMaterial)
      json.member("material", interior_);
    else if (p.material < interior_)
      json.member("material", p.material);
    json.end_object();
  }
  json.end_array();
  if (mesh_manifold_ && !f.topology.empty()) {
    json.key("extensions").begin_object();
    write_mesh_manifold(json, f, {index_view, indices_at, attributes_.front().second, wide}, accessors_);
    json.end_object();
  }
  json.end_object();
}

void MeshWriter::write(JsonText& json, const CollisionHull& hull, const std::string& name) {
  bool good = !hull.points.empty() && hull.points.size() <= kMaxShortVertices && !hull.triangles.empty();
  for (const auto& triangle : hull.triangles)
    for (const std::uint32_t point : triangle) good = good && point < hull.points.size();
  if (!good) throw InternalError(name + ": a collision hull contradicts its own description");

  const std::size_t positions = write_positions(hull.points);
  const std::size_t view = accessors_.view("indices16", 0, kElementArrayBuffer);
  const std::size_t count = 3 * hull.triangles.size();
  const std::size_t at =
      append_indices(accessors_.bytes(view), hull.triangles.front().data(), count, /*wide=*/false);
  json.begin_object().member("name", name).key("primitives").begin_array().begin_object();
  json.key("attributes").begin_object().member("POSITION", positions).end_object();
  json.member("indices", accessors_.add(view, at, component_type::kUnsignedShort, count, "SCALAR"));
  json.end_object().end_array().end_object();
}

}  // namespace fracture
