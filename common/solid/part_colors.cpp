#include "common/solid/part_colors.hpp"
#include <nlohmann/json.hpp>

#include "common/base/pacer.hpp"
#include "common/mesh/material_library.hpp"
#include "common/surface_color/base_color.hpp"
#include "common/surface_color/color_groups.hpp"

namespace fracture::solid_detail {
namespace {

constexpr std::size_t kGroups = 8;
/// Maximum difference of colours in one group, so that the shades of a texture form one group.
constexpr double kAlike = 0.3;

std::vector<bool> translucent_materials(const MaterialLibrary& library) {
  std::vector<bool> translucent;
  for (std::size_t k = 0; k < library.materials.size(); ++k)
    translucent.push_back(base_color(library, k).translucent);
  return translucent;
}

double area_of(const Solid& solid, std::size_t t) {
  const auto& [a, b, c] = solid.triangles[t];
  const Vec3d corner = to_double(solid.positions[a]);
  return length(cross(to_double(solid.positions[b]) - corner, to_double(solid.positions[c]) - corner)) / 2;
}

}  // namespace

void color_parts(const Mesh& mesh, const std::vector<std::uint32_t>& source, Solid& solid,
                 const Execution& execution) {
  if (mesh.triangle_color.empty() && mesh.library->materials.empty()) return;
  const std::vector<bool> translucent = translucent_materials(*mesh.library);
  Pacer pacer(execution);
  ColorHistogram colors;
  const std::vector<std::uint32_t>& part = solid.part;
  const std::size_t count = part.size();
  for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
    colors.clear();
    double clear = 0, all = 0;
    for (; end < count && part[end] == part[begin]; ++end) {
      pacer.step(4);
      const std::uint32_t from = source[end], slot = solid.material[end];
      const double area = area_of(solid, end);
      if (from == kNoIndex || !(area > 0)) continue;
      all += area;
      if (slot < translucent.size() && translucent[slot]) clear += area;
      if (!mesh.triangle_color.empty() && mesh.triangle_color[from].known != 0)
        colors.add(mesh.triangle_color[from].light, area);
    }
    Part& of = solid.parts[part[begin]];
    of.translucent = clear > all / 2;
    if (!colors.empty()) of.color = colors.groups(kGroups, kAlike).means.front();
  }
}

}  // namespace fracture::solid_detail
