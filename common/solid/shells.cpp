#include "common/solid/shells.hpp"

#include <cmath>

#include "common/base/pacer.hpp"
#include "common/exact/volume_sum.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

Vec3d origin_of(const Surface& surface, const Shell& shell) {
  return to_double(surface.positions[surface.triangles[shell.first][0]]);
}

/// Encloses nothing that could be told from rounding.
bool is_flat(const Shell& shell) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::fmax(largest, std::fmax(std::fabs(shell.box.min[axis]), std::fabs(shell.box.max[axis])));
  const double volume = std::fabs(shell.volume);
  return volume <= kFlatRatio * shell.area * std::sqrt(shell.area) ||
         volume <= kThinnestRatio * largest * shell.area;
}

/// Adds up the volumes of these shells once more, with twice the digits.
void refine_volumes(const Surface& surface, const std::vector<std::uint32_t>& cancelling, Shells& shells,
                    const Execution& execution) {
  std::vector<std::uint32_t> slot = filled(execution, shells.list.size(), kNoIndex);
  std::vector<exact::VolumeSum> sums;
  Pacer pacer(execution);
  for (const std::uint32_t id : cancelling) {
    pacer.step();
    slot[id] = static_cast<std::uint32_t>(sums.size());
    sums.emplace_back(origin_of(surface, shells.list[id]));
  }
  for (const TriangleId t : ids<TriangleId>(surface.triangles.size())) {
    pacer.step(4);
    const std::uint32_t s = slot[shells.of_triangle[t]];
    if (s == kNoIndex) continue;
    const Triangle& c = surface.triangles[t];
    sums[s].add(to_double(surface.positions[c[0]]), to_double(surface.positions[c[1]]),
                to_double(surface.positions[c[2]]));
  }
  for (const std::uint32_t id : cancelling) {
    pacer.step();
    shells.list[id].volume = sums[slot[id]].volume();
    shells.list[id].flat = is_flat(shells.list[id]);
  }
}

}  // namespace

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
  std::vector<double> edge_products = filled(execution, first.size(), 0.0);
  for_each_polled(execution, first.size(), [&](std::size_t s) { shells.list[s].first = first[s]; });
  for (TriangleId t{0}; t < surface.triangles.size();) {
    const std::uint32_t id = shells.of_triangle[t];
    Shell& shell = shells.list[id];
    const Vec3d origin = origin_of(surface, shell);
    // Triangles of one shell come in long runs: its sums stay in registers.
    const TriangleId begin = t;
    Box box;
    double volume = 0, area = 0, products = 0;
    for (; t < surface.triangles.size() && shells.of_triangle[t] == id; ++t) {
      pacer.step();
      const Triangle& corners = surface.triangles[t];
      const Vec3d a = to_double(surface.positions[corners[0]]), b = to_double(surface.positions[corners[1]]),
                  c = to_double(surface.positions[corners[2]]);
      box.add(a);
      box.add(b);
      box.add(c);
      const Vec3d ab = b - a, ac = c - a, normal = cross(ab, ac);
      volume += dot(a - origin, normal);  // six times the tetrahedron (origin, a, b, c)
      area += length(normal);
      products += exact::max_norm(ab) * exact::max_norm(ac);
    }
    shell.triangles += t - begin;
    shell.box.add(box);
    shell.volume += volume;
    shell.area += area;
    edge_products[id] += products;
  }
  std::vector<std::uint32_t> cancelling;
  for (Shell& shell : shells.list) {
    pacer.step();
    shell.volume /= 6;
    shell.area /= 2;
    shell.flat = is_flat(shell);
    const auto id = static_cast<std::uint32_t>(&shell - shells.list.data());
    if (!shell.flat && exact::cancels(shell.volume, edge_products[id], shell.box.longest_side()))
      cancelling.push_back(id);
  }
  if (!cancelling.empty()) refine_volumes(surface, cancelling, shells, execution);
  return shells;
}

}  // namespace fracture::solid_detail
