#include "common/import/complete_attributes.hpp"

#include <algorithm>

#include "common/import/transform.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxUvSets = 8;  // a material that uses a higher set is damaged

/// Returns the non-negative integer `object[key]`, or the fallback.
std::uint64_t index_at(const json& object, const char* key, std::uint64_t fallback) {
  const auto it = object.find(key);
  return it != object.end() && it->is_number_integer() && it->get<std::int64_t>() >= 0
             ? it->get<std::uint64_t>()
             : fallback;
}

/// The highest texCoord in any texture reference inside, plus one; 0 if there is none.
std::uint64_t uv_sets_needed(const json& value) {
  std::uint64_t needed = 0;
  if (value.is_object() && value.contains("index")) {
    needed = 1 + index_at(value, "texCoord", 0);
    const json::json_pointer transform("/extensions/KHR_texture_transform");
    if (value.contains(transform) && value[transform].is_object())
      needed = std::max(needed, 1 + index_at(value[transform], "texCoord", 0));
  }
  if (value.is_structured())
    for (const auto& [key, child] : value.items())
      if (key != "extras" && child.is_structured()) needed = std::max(needed, uv_sets_needed(child));
  return std::min(needed, kMaxUvSets);
}

/// Returns kNoIndex if the material has no normal map.
std::uint32_t uv_set_of_normal_map(const json& material) {
  const auto it = material.find("normalTexture");
  if (it == material.end() || !it->is_object()) return kNoIndex;
  const std::uint64_t number = index_at(*it, "texCoord", 0);
  return number < kMaxUvSets ? static_cast<std::uint32_t>(number) : kNoIndex;
}

void clamp_colors(Mesh& mesh) {
  bool changed = false;
  const auto clamp = [&changed](float& c) {
    const float clamped = std::clamp(c, 0.0f, 1.0f);
    changed |= clamped != c;
    c = clamped;
  };
  for (auto& set : mesh.attributes.colors)
    for (Vec4f& c : set) clamp(c.x), clamp(c.y), clamp(c.z), clamp(c.w);
  if (changed) mesh.remarks.note("Colours outside [0, 1] were clamped.");
}

/// Computes smooth normals, weighted by area, for a mesh without normals whose normal maps need a tangent
/// frame.
void compute_normals(Mesh& mesh) {
  std::vector<Vec3d> sums(mesh.positions.size());
  for (const auto& t : mesh.triangles) {
    const Vec3d a = to_double(mesh.positions[t[0]]);
    const Vec3d n = cross(to_double(mesh.positions[t[1]]) - a, to_double(mesh.positions[t[2]]) - a);
    for (const std::uint32_t wedge : t) sums[wedge] = sums[wedge] + n;
  }
  mesh.attributes.normals.resize(mesh.positions.size());
  for (std::size_t v = 0; v < sums.size(); ++v) mesh.attributes.normals[v] = unit_float(sums[v]);
}

}  // namespace

void compute_tangents(Mesh& mesh, const std::vector<std::uint32_t>& uv_set_of_material) {
  const std::size_t count = mesh.positions.size();
  std::vector<Vec3d> right(count), up(count);
  std::vector<bool> touched(count, false);
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const std::uint32_t material = mesh.material[k];
    if (material >= uv_set_of_material.size() || uv_set_of_material[material] == kNoIndex) continue;
    const auto& uvs = mesh.attributes.uvs.at(uv_set_of_material[material]);
    const auto& t = mesh.triangles[k];
    const Vec3d p0 = to_double(mesh.positions[t[0]]);
    const Vec3d e1 = to_double(mesh.positions[t[1]]) - p0, e2 = to_double(mesh.positions[t[2]]) - p0;
    const double u1 = double{uvs[t[1]].x} - uvs[t[0]].x, u2 = double{uvs[t[2]].x} - uvs[t[0]].x;
    const double v1 = double{uvs[t[1]].y} - uvs[t[0]].y, v2 = double{uvs[t[2]].y} - uvs[t[0]].y;
    const double area = u1 * v2 - u2 * v1;  // only its sign is used, because directions are normalised
    for (const std::uint32_t wedge : t) touched[wedge] = true;
    if (area == 0) continue;
    const double sign = area < 0 ? -1 : 1;
    Vec3d grow_u = sign * (v2 * e1 - v1 * e2), fall_v = -sign * (u1 * e2 - u2 * e1);
    const double weight = length(cross(e1, e2)), lu = length(grow_u), lv = length(fall_v);
    if (!(lu > 0) || !(lv > 0)) continue;
    for (const std::uint32_t wedge : t) {
      right[wedge] = right[wedge] + (weight / lu) * grow_u;
      up[wedge] = up[wedge] + (weight / lv) * fall_v;
    }
  }
  mesh.attributes.tangents.resize(count);
  for (std::size_t v = 0; v < count; ++v) {
    if (!touched[v]) continue;
    const Vec3d n = to_double(mesh.attributes.normals[v]);
    const Vec3f t = unit_float(right[v] - dot(n, right[v]) * n);
    const float w = dot(cross(n, right[v]), up[v]) < 0 ? -1.0f : 1.0f;
    mesh.attributes.tangents[v] = t == Vec3f{} ? Vec4f{} : Vec4f{t.x, t.y, t.z, w};
  }
}

void complete_attributes(Mesh& mesh) {
  clamp_colors(mesh);
  const json& materials = mesh.library->materials;
  std::vector<bool> used(materials.size(), false);
  for (const std::uint32_t material : mesh.material)
    if (material < used.size()) used[material] = true;

  std::uint64_t sets = 0;
  std::vector<std::uint32_t> normal_map(materials.size(), kNoIndex);
  bool any_normal_map = false;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (!used[m]) continue;
    for (const std::size_t look : looks_of(*mesh.library, m)) {
      sets = std::max(sets, uv_sets_needed(materials[look]));
      if (normal_map[m] == kNoIndex) normal_map[m] = uv_set_of_normal_map(materials[look]);
    }
    any_normal_map = any_normal_map || normal_map[m] != kNoIndex;
  }
  if (sets > mesh.attributes.uvs.size()) {
    mesh.remarks.warn(
        "A material has a texture, but the mesh has no UVs for it, so all UVs are 0. The surface shows one "
        "colour of the texture. Give the mesh UVs in a modelling tool.");
    while (mesh.attributes.uvs.size() < sets) mesh.attributes.uvs.emplace_back(mesh.positions.size());
  }
  if (!any_normal_map || !mesh.attributes.tangents.empty()) return;
  if (mesh.attributes.normals.empty()) {
    compute_normals(mesh);
    mesh.remarks.note("Normals were computed, because a normal map needs them and the file has none.");
  }
  compute_tangents(mesh, normal_map);
  mesh.remarks.note("Tangents were computed, because a normal map needs them and the file has none.");
}

}  // namespace fracture
