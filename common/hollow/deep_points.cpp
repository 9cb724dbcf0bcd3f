#include "common/hollow/deep_points.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"

namespace fracture::hollow_detail {
namespace {

/// Of a cube, as a multiple of half its side: a little more than the root of three.
constexpr double kHalfDiagonal = 1.7321;
/// Half the side of the smallest cube in which the middle of a ball is looked for, of its radius.
constexpr double kFinest = 1.0 / 32;

struct Cube {
  Vec3d center;
  double half;
};

/// How often the triangles enclose the point: near a whole number for a closed surface that is not near.
double winding(const SurfaceTree& surface, const Vec3d& point, Pacer& pacer) {
  double angle = 0;
  for (const auto& corners : surface.corners()) {
    pacer.step(4);
    const Vec3d a = corners[0] - point, b = corners[1] - point, c = corners[2] - point;
    const double la = length(a), lb = length(b), lc = length(c);
    angle +=
        2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

}  // namespace

std::vector<std::uint8_t> deep_points(const SurfaceTree& surface, const Lattice& lattice, double depth,
                                      std::uint32_t smallest, const Execution& execution) {
  const std::uint32_t points = lattice.points();
  std::vector<std::uint8_t> deep(points, 0);
  parallel_for(execution, points, 512, [&](std::size_t begin, std::size_t end) {
    Pacer pacer(execution);
    for (std::size_t p = begin; p < end; ++p)
      deep[p] = !surface.within(lattice.place(static_cast<std::uint32_t>(p)), depth, pacer);
  });

  // The balls around two neighbours cover what is between them: both are on one side of the surface, and one
  // point tells for all that hang together.
  Pacer pacer(execution);
  DisjointSets groups;
  groups.reserve(points);
  for (std::uint32_t p = 0; p < points; ++p) groups.add();
  lattice.each_cube([&](std::uint32_t p) {
    pacer.step();
    for (std::uint32_t bits = 1; deep[p] && bits < 8; ++bits)
      if (const std::uint32_t q = lattice.neighbour(p, bits); deep[q]) groups.unite(p, q);
  });
  std::vector<std::uint32_t> members(points, 0);
  for (std::uint32_t p = 0; p < points; ++p) members[groups.find(p)] += deep[p];
  std::vector<std::uint8_t> inside(points, 0);   // of roots
  const std::uint32_t outside = groups.find(0);  // the first corner of the lattice is
  for (std::uint32_t p = 0; p < points; ++p)
    if (members[p] >= smallest && p != outside) inside[p] = winding(surface, lattice.place(p), pacer) > 0.5;
  for (std::uint32_t p = 0; p < points; ++p) deep[p] = deep[p] && inside[groups.find(p)];
  return deep;
}

bool holds_ball(const SurfaceTree& surface, const Box& box, double radius, const Execution& execution) {
  // The middle of such a ball is in the cube around one of these points: half the diagonal from it, or less. All of that
  // cube is inside, because the surface is farther from the point than that.
  const Lattice lattice(box, radius / 2);
  const std::vector<std::uint8_t> near_a_middle =
      deep_points(surface, lattice, (1 - kHalfDiagonal / 4) * radius, 1, execution);
  Pacer pacer(execution);
  std::vector<Cube> waiting;
  for (std::uint32_t p = 0; p < near_a_middle.size(); ++p) {
    pacer.step();
    if (near_a_middle[p]) waiting.push_back({lattice.place(p), radius / 4});
    while (!waiting.empty()) {
      const Cube cube = waiting.back();
      waiting.pop_back();
      pacer.step();
      if (!surface.within(cube.center, radius, pacer)) return true;
      if (cube.half <= kFinest * radius ||
          surface.within(cube.center, radius - kHalfDiagonal * cube.half, pacer))
        continue;
      for (int octant = 0; octant < 8; ++octant) {
        const auto step = [&](int bit) { return (octant & bit) != 0 ? cube.half / 2 : -cube.half / 2; };
        waiting.push_back({cube.center + Vec3d{step(1), step(2), step(4)}, cube.half / 2});
      }
    }
  }
  return false;
}

}  // namespace fracture::hollow_detail
