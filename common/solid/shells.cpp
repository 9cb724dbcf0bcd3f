#include "common/solid/shells.hpp"

#include <cmath>

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {

Shells find_shells(const Surface& surface, const Execution& execution) {
  Shells shells;
  shells.of_triangle = filled(execution, surface.triangles.size(), kNoIndex);
  Pacer pacer(execution);
  std::vector<TriangleId> stack, first;
  for (const TriangleId seed : ids<TriangleId>(surface.triangles.size())) {
    if (seed % 65536 == 0) execution.poll();
    if (shells.of_triangle[seed] != kNoIndex) continue;
    const auto id = static_cast<std::uint32_t>(first.size());
    first.push_back(seed);
    stack.assign(1, seed);
    shells.of_triangle[seed] = id;
    while (!stack.empty()) {
      const TriangleId t = stack.back();
      stack.pop_back();
      pacer.step();
      for (HalfEdge h = 3 * t; h < 3 * t + 3; ++h) {
        const TriangleId neighbour = triangle_of(surface.twin[h]);
        if (shells.of_triangle[neighbour] != kNoIndex) continue;
        shells.of_triangle[neighbour] = id;
        stack.push_back(neighbour);
      }
    }
  }
  shells.list = filled(execution, first.size(), Shell{});
  for_each_polled(execution, first.size(), [&](std::size_t s) { shells.list[s].first = first[s]; });
  for (TriangleId t{0}; t < surface.triangles.size();) {
    const std::uint32_t id = shells.of_triangle[t];
    Shell& shell = shells.list[id];
    const Vec3d origin = to_double(surface.positions[surface.triangles[shell.first][0]]);
    // Triangles of one shell come in long runs: its sums stay in registers.
    const TriangleId begin = t;
    Box box;
    double volume = 0, area = 0;
    for (; t < surface.triangles.size() && shells.of_triangle[t] == id; ++t) {
      pacer.step();
      const Triangle& corners = surface.triangles[t];
      const Vec3d a = to_double(surface.positions[corners[0]]), b = to_double(surface.positions[corners[1]]),
                  c = to_double(surface.positions[corners[2]]);
      box.add(a);
      box.add(b);
      box.add(c);
      const Vec3d normal = cross(b - a, c - a);
      volume += dot(a - origin, normal);  // six times the tetrahedron (origin, a, b, c)
      area += length(normal);
    }
    shell.triangles += t - begin;
    shell.box.add(box);
    shell.volume += volume;
    shell.area += area;
  }
  for (Shell& shell : shells.list) {
    pacer.step();
    shell.volume /= 6;
    shell.area /= 2;
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis)
      largest = std::fmax(largest, std::fmax(std::fabs(shell.box.min[axis]), std::fabs(shell.box.max[axis])));
    const double volume = std::fabs(shell.volume);
    shell.flat = volume <= kFlatRatio * shell.area * std::sqrt(shell.area) ||
                 volume <= kThinnestRatio * largest * shell.area;
  }
  return shells;
}

}  // namespace fracture::solid_detail
