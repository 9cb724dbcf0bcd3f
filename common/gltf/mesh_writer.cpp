#include "common/gltf/mesh_writer.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/gltf/mesh_manifold.hpp"
#include "common/mesh/gltf_component.hpp"
#include "common/mesh/material_library.hpp"
#include "common/solid/cut_materials.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

MeshWriter::MeshWriter(const MaterialLibrary& library, const InteriorMaterials& interior,
                       const ExteriorMaterials& exterior, bool mesh_manifold, Accessors& accessors)
    : accessors_(accessors),
      mesh_manifold_(mesh_manifold),
      library_(library),
      interior_(interior),
      exterior_(exterior),
      first_interior_(library.materials.size()),
      first_exterior_(first_interior_ + interior.materials.size() + interior.cavities.size()) {
  Pacer pacer(accessors.execution());
  const auto step = [&] { pacer.step(8); };
  for (const auto& material : library.materials) normal_mapped_.push_back(has_normal_map(material, step));
  const std::vector<bool> own = normal_mapped_;
  for (std::size_t k = 0; k < library.variant_mappings.size(); ++k) {
    pacer.step();
    for (const std::size_t look : looks_of(library, k)) normal_mapped_[k] = normal_mapped_[k] || own[look];
  }
  for (const auto* list : {&interior.materials, &interior.cavities, &exterior.materials})
    for (const auto& material : *list) normal_mapped_.push_back(has_normal_map(material, step));
  std::fill_n(normal_mapped_.begin() + static_cast<std::ptrdiff_t>(first_interior_), interior.in_relief,
              true);
}

std::optional<std::size_t> MeshWriter::material_of(const Fragment& f, const FragmentPrimitive& p,
                                                   const ExteriorMaterials& exterior) const {
  const std::uint32_t part = p.part == kNoIndex ? f.source_part : p.part;
  if (p.material == kInteriorMaterial) return first_interior_ + interior_.of(part, f.mass.volume);
  if (p.material == kMortarMaterial && interior_.mortar_of(part) != kNoIndex)
    return first_interior_ + interior_.mortar_of(part);
  if (p.material == kCavityMaterial && !interior_.cavities.empty())
    return first_interior_ + interior_.materials.size() + interior_.of(part);
  if (const std::uint32_t made = exterior.of(p.material, part); made != kNoIndex)
    return first_exterior_ + made;
  if (p.material < first_interior_) return p.material;
  return std::nullopt;
}

std::size_t MeshWriter::put_positions(const std::vector<Vec3f>& positions, const Bounds& bounds) {
  BufferContents& contents = accessors_.contents();
  const std::size_t view = contents.view("POSITION", sizeof(Vec3f), kArrayBuffer);
  const std::size_t at = contents.put<write_positions>(view, positions.size() * sizeof(Vec3f), positions);
  return accessors_.add(view, at, component_type::kFloat, positions.size(), "VEC3", &bounds.min, &bounds.max);
}

// The source has normals and tangents if its own materials need them (import/complete_attributes.hpp). If it has none but
// the materials of its cuts need them, they are made for the cuts only, and the outside stays unchanged.
void MeshWriter::put_attributes(const Fragment& f, const MeshFigures& figures) {
  bool any_mapped = false, any_mapped_cuts = false;
  for (std::size_t k = 0; k < f.primitives.size(); ++k) {
    any_mapped = any_mapped || is_mapped(k);
    any_mapped_cuts = any_mapped_cuts || (is_mapped(k) && is_of_cuts(f.primitives[k].material));
  }
  BufferContents& contents = accessors_.contents();
  const std::size_t count = f.positions.size();
  attributes_.clear();
  attributes_.push_back({"POSITION", put_positions(f.positions, figures.bounds)});
  const auto attribute = [&](const std::string& semantic, int stride, const char* type, const auto& put,
                             Bearers bearers = Bearers::kAll) {
    const std::size_t view = contents.view(semantic, stride, kArrayBuffer);
    const std::size_t at = put(view, count * static_cast<std::size_t>(stride));
    attributes_.push_back({semantic, accessors_.add(view, at, component_type::kFloat, count, type), bearers});
  };
  if (!f.attributes.normals.empty())
    attribute("NORMAL", sizeof(Vec3f), "VEC3", [&](std::size_t view, std::size_t bytes) {
      return contents.put<write_normals>(view, bytes, f);
    });
  else if (any_mapped_cuts)
    attribute(
        "NORMAL", sizeof(Vec3f), "VEC3",
        [&](std::size_t view, std::size_t bytes) { return contents.put<write_cut_normals>(view, bytes, f); },
        Bearers::kMappedCuts);
  for (std::size_t set = 0; set < f.attributes.uvs.size(); ++set)
    attribute("TEXCOORD_" + std::to_string(set), sizeof(Vec2f), "VEC2",
              [&](std::size_t view, std::size_t bytes) {
                if (interior_.uvs == CutUvs{})
                  return contents.put<write_uvs>(view, bytes, f.attributes.uvs[set]);
                return contents.put<write_moved_uvs>(
                    view, bytes, moved_uvs_.emplace_back(MovedUvs{f, set, interior_.uvs}));
              });
  for (std::size_t set = 0; set < f.attributes.colors.size(); ++set)
    attribute("COLOR_" + std::to_string(set), sizeof(Vec4f), "VEC4",
              [&](std::size_t view, std::size_t bytes) {
                return contents.put<write_colors>(view, bytes, f.attributes.colors[set]);
              });
  if (any_mapped && !f.attributes.tangents.empty())
    attribute(
        "TANGENT", sizeof(Vec4f), "VEC4",
        [&](std::size_t view, std::size_t bytes) { return contents.put<write_tangents>(view, bytes, f); },
        Bearers::kMapped);
  else if (any_mapped_cuts)
    attribute(
        "TANGENT", sizeof(Vec4f), "VEC4",
        [&](std::size_t view, std::size_t bytes) { return contents.put<write_cut_tangents>(view, bytes, f); },
        Bearers::kMappedCuts);
}

void MeshWriter::write_variants(JsonText& json, std::size_t material) const {
  if (material >= library_.variant_mappings.size() || library_.variant_mappings[material].empty()) return;
  json.key("extensions").begin_object();
  json.member("KHR_materials_variants", library_.variant_mappings[material]).end_object();
}

void MeshWriter::write(JsonText& json, const Fragment& f, const MeshFigures& figures,
                       const std::string& name) {
  write(json, f, figures, name, exterior_);
}

void MeshWriter::write_whole(JsonText& json, const Fragment& f, const MeshFigures& figures,
                             const std::string& name) {
  write(json, f, figures, name, {});
}

void MeshWriter::write(JsonText& json, const Fragment& f, const MeshFigures& figures, const std::string& name,
                       const ExteriorMaterials& exterior) {
  materials_.clear();
  for (const FragmentPrimitive& p : f.primitives) materials_.push_back(material_of(f, p, exterior));
  put_attributes(f, figures);

  const bool wide = f.positions.size() > kMaxShortVertices;
  BufferContents& contents = accessors_.contents();
  const std::size_t index_view = contents.view(wide ? "indices32" : "indices16", 0, kElementArrayBuffer);
  const std::size_t indices_at =
      wide ? contents.put<write_long_indices>(index_view, 4 * f.indices.size(), f.indices)
           : contents.put<write_short_indices>(index_view, 2 * f.indices.size(), f.indices);

  json.begin_object().member("name", name).key("primitives").begin_array();
  for (std::size_t k = 0, next = 0; k < f.primitives.size(); k = next) {
    // Cuts through several parts become one primitive if they look alike.
    FragmentPrimitive p = f.primitives[k];
    for (next = k + 1; next < f.primitives.size() && materials_[next] == materials_[k] &&
                       f.primitives[next].material == p.material;
         ++next)
      p.index_count += f.primitives[next].index_count;
    const std::size_t bytes = wide ? 4 : 2;
    json.begin_object().key("attributes").begin_object();
    const Bearers here = !is_mapped(k)             ? Bearers::kAll
                         : !is_of_cuts(p.material) ? Bearers::kMapped
                                                   : Bearers::kMappedCuts;
    for (const Attribute& attribute : attributes_)
      if (attribute.bearers <= here) json.member(attribute.semantic, attribute.accessor);
    json.end_object();
    json.member("indices",
                accessors_.add(index_view, indices_at + bytes * p.first_index,
                               wide ? component_type::kUnsignedInt : component_type::kUnsignedShort,
                               p.index_count, "SCALAR"));
    if (materials_[k]) {
      json.member("material", *materials_[k]);
      write_variants(json, *materials_[k]);
    }
    json.end_object();
  }
  json.end_array();
  if (mesh_manifold_ && !f.topology.empty()) {
    json.key("extensions").begin_object();
    write_mesh_manifold(json, f, {index_view, indices_at, attributes_.front().accessor, wide, figures.merged},
                        accessors_);
    json.end_object();
  }
  json.end_object();
}

void MeshWriter::write(JsonText& json, const CollisionHull& hull, const std::string& name) {
  bool good = !hull.points.empty() && hull.points.size() <= kMaxShortVertices && !hull.triangles.empty();
  for (const auto& triangle : hull.triangles)
    for (const std::uint32_t point : triangle) good = good && point < hull.points.size();
  if (!good)
    throw InternalError(name + ": a collision hull is empty, too large or refers to a missing point");

  Pacer pacer(accessors_.execution());
  const std::size_t positions = put_positions(hull.points, bounds_of(hull.points, pacer));
  BufferContents& contents = accessors_.contents();
  const std::size_t view = contents.view("indices16", 0, kElementArrayBuffer);
  const std::size_t count = 3 * hull.triangles.size();
  const std::size_t at = contents.put<write_short_triangles>(view, 2 * count, hull.triangles);
  json.begin_object().member("name", name).key("primitives").begin_array().begin_object();
  json.key("attributes").begin_object().member("POSITION", positions).end_object();
  json.member("indices", accessors_.add(view, at, component_type::kUnsignedShort, count, "SCALAR"));
  json.end_object().end_array().end_object();
}

}  // namespace fracture
