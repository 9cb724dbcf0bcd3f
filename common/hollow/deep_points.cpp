#include "common/hollow/deep_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"

namespace fracture::hollow_detail {
namespace {

/// Half the diagonal of a cube divided by half its side: slightly more than √3.
constexpr double kHalfDiagonal = 1.7321;
/// Half the side of the smallest cube in which the middle of a ball is searched for, divided by the ball's
/// radius.
constexpr double kFinest = 1.0 / 32;

struct Cube {
  Vec3d center;
  double half;
};

/// The winding number of the triangles around the point. Near an integer if the surface is closed and not
/// near the point.
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

/// Classifies whole blocks of points by the distance of one point: the distances of two points to the surface
/// differ by at most the distance between the points.
class Depths {
 public:
  Depths(const SurfaceTree& surface, const Lattice& lattice, double depth, std::vector<std::uint8_t>& deep,
         const Execution& execution)
      : surface_(surface), lattice_(lattice), depth_(depth), deep_(deep), pacer_(execution) {
    for (int axis = 0; axis < 3; ++axis)
      rounding_ = std::fmax(rounding_, std::fabs(lattice.low(axis)) + lattice.size(axis) * lattice.step());
    rounding_ *= kRounding;
  }

  struct Block {
    std::array<std::uint32_t, 3> low, high;  ///< the points from `low` up to, but not including, `high`
  };

  void tell(const Block& block) {
    std::size_t longest = 0;
    Vec3d first = lattice_.place(at(block.low)), last = first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t sides = block.high[axis] - block.low[axis] - 1;
      last[static_cast<int>(axis)] += lattice_.step() * sides;
      if (block.high[axis] - block.low[axis] > block.high[longest] - block.low[longest]) longest = axis;
    }
    pacer_.step();
    if (block.high[longest] - block.low[longest] == 1) {
      deep_[at(block.low)] = !surface_.within(first, depth_, pacer_);
      return;
    }
    const double radius = length(last - first) / 2 + rounding_;
    const Vec3d middle = 0.5 * (first + last);
    if (!surface_.within(middle, depth_ + radius, pacer_)) return fill(block, 1);
    if (depth_ > radius && surface_.within(middle, depth_ - radius, pacer_)) return fill(block, 0);
    Block lower = block, upper = block;
    lower.high[longest] = upper.low[longest] = (block.low[longest] + block.high[longest]) / 2;
    tell(lower);
    tell(upper);
  }

 private:
  /// Exceeds the error of a distance, relative to the largest coordinate, so blocks give the same result as
  /// single points.
  static constexpr double kRounding = 1e-11;

  std::uint32_t at(const std::array<std::uint32_t, 3>& p) const { return lattice_.at(p[0], p[1], p[2]); }

  void fill(const Block& block, std::uint8_t is_deep) {
    for (std::uint32_t z = block.low[2]; z < block.high[2]; ++z)
      for (std::uint32_t y = block.low[1]; y < block.high[1]; ++y)
        std::fill_n(deep_.begin() + lattice_.at(block.low[0], y, z), block.high[0] - block.low[0], is_deep);
  }

  const SurfaceTree& surface_;
  const Lattice& lattice_;
  const double depth_;
  std::vector<std::uint8_t>& deep_;
  Pacer pacer_;
  double rounding_ = 0;  ///< m
};

/// Number of points along each side of the blocks that threads process.
constexpr std::uint32_t kBlock = 16;

std::vector<Depths::Block> blocks_of(const Lattice& lattice) {
  const auto after = [&](std::uint32_t low, int axis) { return std::min(low + kBlock, lattice.size(axis)); };
  std::vector<Depths::Block> blocks;
  for (std::uint32_t z = 0; z < lattice.size(2); z += kBlock)
    for (std::uint32_t y = 0; y < lattice.size(1); y += kBlock)
      for (std::uint32_t x = 0; x < lattice.size(0); x += kBlock)
        blocks.push_back({{x, y, z}, {after(x, 0), after(y, 1), after(z, 2)}});
  return blocks;
}

}  // namespace

std::vector<std::uint8_t> deep_points(const SurfaceTree& surface, const Lattice& lattice, double depth,
                                      std::uint32_t smallest, const Execution& execution) {
  const std::uint32_t points = lattice.points();
  std::vector<std::uint8_t> deep(points, 0);
  const std::vector<Depths::Block> blocks = blocks_of(lattice);
  parallel_for(execution, blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
    Depths depths(surface, lattice, depth, deep, execution);
    for (std::size_t k = begin; k < end; ++k) depths.tell(blocks[k]);
  });

  // The balls around two neighbouring points cover the space between them, so both are on the same side of
  // the surface. One point therefore decides for its whole connected group.
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
  std::vector<std::uint8_t> inside(points, 0);   // only for roots
  const std::uint32_t outside = groups.find(0);  // the first corner of the lattice is outside
  for (std::uint32_t p = 0; p < points; ++p)
    if (members[p] >= smallest && p != outside) inside[p] = winding(surface, lattice.place(p), pacer) > 0.5;
  for (std::uint32_t p = 0; p < points; ++p) deep[p] = deep[p] && inside[groups.find(p)];
  return deep;
}

bool holds_ball(const SurfaceTree& surface, const Box& box, double radius, const Execution& execution) {
  // The middle of such a ball is in the cube around one of these points, at most half a diagonal away. The
  // whole cube is inside, because the surface is farther from the point.
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
