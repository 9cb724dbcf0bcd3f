#include "common/solid/shells.hpp"

#include <cmath>

#include "common/solid/float_predicates.hpp"

namespace fracture::solid_detail {
namespace {

bool exactly_zero_volume(const Surface& surface, const std::vector<std::uint32_t>& shell_of,
                         std::uint32_t shell, TriangleId first) {
  ExactSum sum;
  for (TriangleId t = first; t < surface.triangles.size(); ++t) {
    if (shell_of[t] != shell) continue;
    const Vec3f &a = surface.positions[surface.triangles[t][0]],
                &b = surface.positions[surface.triangles[t][1]],
                &c = surface.positions[surface.triangles[t][2]];
    const double by = b.y, bz = b.z, bx = b.x;
    sum.add_product(by * c.z, a.x);
    sum.add_product(-(bz * c.y), a.x);
    sum.add_product(bz * c.x, a.y);
    sum.add_product(-(bx * c.z), a.y);
    sum.add_product(bx * c.y, a.z);
    sum.add_product(-(by * c.x), a.z);
  }
  return sum.sign() == 0;
}

}  // namespace

Shells find_shells(const Surface& surface, const Execution& execution) {
  execution.poll();
  Shells shells;
  shells.of_triangle.assign(surface.triangles.size(), kNoIndex);
  std::vector<TriangleId> stack;
  for (TriangleId seed = 0; seed < surface.triangles.size(); ++seed) {
    if (shells.of_triangle[seed] != kNoIndex) continue;
    const auto id = static_cast<std::uint32_t>(shells.list.size());
    Shell& shell = shells.list.emplace_back();
    shell.first = seed;
    stack.assign(1, seed);
    shells.of_triangle[seed] = id;
    while (!stack.empty()) {
      const TriangleId t = stack.back();
      stack.pop_back();
      ++shell.triangles;
      for (HalfEdge h = 3 * t; h < 3 * t + 3; ++h) {
        const TriangleId neighbour = surface.twin[h] / 3;
        if (shells.of_triangle[neighbour] != kNoIndex) continue;
        shells.of_triangle[neighbour] = id;
        stack.push_back(neighbour);
      }
    }
  }
  execution.poll();
  std::vector<double> magnitude(shells.list.size(), 0);
  for (TriangleId t = 0; t < surface.triangles.size();) {
    const std::uint32_t id = shells.of_triangle[t];
    Shell& shell = shells.list[id];
    const Vec3d origin = to_double(surface.positions[surface.triangles[shell.first][0]]);
    // Triangles of one shell come in long runs: its sums stay in registers.
    Box box;
    double volume = 0, area = 0, sum = 0;
    for (; t < surface.triangles.size() && shells.of_triangle[t] == id; ++t) {
      const Triangle& corners = surface.triangles[t];
      const Vec3d a = to_double(surface.positions[corners[0]]), b = to_double(surface.positions[corners[1]]),
                  c = to_double(surface.positions[corners[2]]);
      box.add(a);
      box.add(b);
      box.add(c);
      const Vec3d normal = cross(b - a, c - a);
      const double term = dot(a - origin, normal);  // six times the tetrahedron (origin, a, b, c)
      volume += term;
      area += length(normal);
      sum += std::fabs(term);
    }
    shell.box.add(box);
    shell.volume += volume;
    shell.area += area;
    magnitude[id] += sum;
  }
  for (std::uint32_t id = 0; id < shells.list.size(); ++id) {
    Shell& shell = shells.list[id];
    shell.volume /= 6;
    shell.area /= 2;
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis)
      largest = std::fmax(largest, std::fmax(std::fabs(shell.box.min[axis]), std::fabs(shell.box.max[axis])));
    const double volume = std::fabs(shell.volume);
    shell.flat = volume <= kFlatRatio * shell.area * std::sqrt(shell.area) ||
                 volume <= 0x1.0p-24 * largest * shell.area ||
                 (volume <= 1e-13 * magnitude[id] &&
                  exactly_zero_volume(surface, shells.of_triangle, id, shell.first));
  }
  return shells;
}

}  // namespace fracture::solid_detail
