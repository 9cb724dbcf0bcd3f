#include "common/solid/corners.hpp"

#include "common/base/pacer.hpp"

namespace fracture {

std::vector<std::array<Vec3d, 3>> corners_of(const Solid& solid, std::size_t begin, std::size_t end,
                                             const Execution& execution) {
  std::vector<std::array<Vec3d, 3>> corners;
  corners.reserve(end - begin);
  Pacer(execution).each(begin, end, [&](std::size_t t) {
    const auto& [a, b, c] = solid.triangles[t];
    corners.push_back(
        {to_double(solid.positions[a]), to_double(solid.positions[b]), to_double(solid.positions[c])});
  });
  return corners;
}

std::vector<std::array<Vec3d, 3>> corners_of(const Solid& solid, const Execution& execution) {
  return corners_of(solid, 0, solid.triangles.size(), execution);
}

}  // namespace fracture
