#include "common/fragment/certain_volume.hpp"

#include <algorithm>

#include "common/exact/volume_sum.hpp"

namespace fracture {

double certain_volume(double volume, std::span<const Vec3d> points, const Box& box,
                      std::span<const std::uint32_t> triangles, Pacer& pacer) {
  // Usually the box is enough to decide: in the maximum norm, no edge is longer than its longest side. (A
  // thousandth more is far more than any rounding error.)
  const double side = 1.001 * box.longest_side();
  const std::size_t count = triangles.size() / 3;
  if (!exact::cancels(volume, static_cast<double>(count) * side * side, side)) return volume;

  const Vec3d origin = points[triangles[0]];
  double products = 0, reach = 0;
  for (std::size_t k = 0; k < triangles.size(); k += 3) {
    pacer.step();
    const Vec3d a = points[triangles[k]] - origin, b = points[triangles[k + 1]] - origin,
                c = points[triangles[k + 2]] - origin;
    products += exact::max_norm(b - a) * exact::max_norm(c - a);
    reach = std::max(reach, exact::max_norm(a));
  }
  if (!exact::cancels(volume, products, reach)) return volume;

  exact::VolumeSum sum(origin);
  for (std::size_t k = 0; k < triangles.size(); k += 3) {
    pacer.step(4);
    sum.add(points[triangles[k]], points[triangles[k + 1]], points[triangles[k + 2]]);
  }
  return sum.volume();
}

}  // namespace fracture
