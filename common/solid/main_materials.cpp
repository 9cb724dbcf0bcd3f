#include "common/solid/main_materials.hpp"

#include <algorithm>
#include <map>

#include "common/base/pacer.hpp"
#include "common/solid/cut_materials.hpp"

namespace fracture {

std::vector<std::uint32_t> main_materials(const Solid& solid, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::map<std::uint32_t, double>> area_of(solid.parts.size());
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(8);
    if (is_of_cuts(solid.material[t]) || solid.material[t] == kCavityMaterial) continue;
    const auto& [a, b, c] = solid.triangles[t];
    const Vec3d corner = to_double(solid.positions[a]);
    area_of[solid.part[t]][solid.material[t]] +=
        length(cross(to_double(solid.positions[b]) - corner, to_double(solid.positions[c]) - corner));
  }
  std::vector<std::uint32_t> main(solid.parts.size(), kInteriorMaterial);
  for (std::size_t p = 0; p < main.size(); ++p) {
    pacer.step(8);
    const auto most = std::max_element(area_of[p].begin(), area_of[p].end(),
                                       [](const auto& x, const auto& y) { return x.second < y.second; });
    if (most != area_of[p].end()) main[p] = most->first;
  }
  return main;
}

}  // namespace fracture
