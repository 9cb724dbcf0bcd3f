// Bricks laid in courses, and which of them a solid meets.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/sites/division.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {

/// Bricks as sites: those of a brick's cells, one after the other.
struct Bricks {
  struct Brick {
    Vec3d middle, half;   ///< in the image; half of its sides
    std::uint32_t first;  ///< of its cells
  };
  std::vector<Vec3d> cells;
  std::vector<Brick> bricks;
  std::uint32_t end_of(std::size_t brick) const {
    return brick + 1 < bricks.size() ? bricks[brick + 1].first : static_cast<std::uint32_t>(cells.size());
  }
};

/// A brick is as many cells as the shift of a course divides it into.
inline std::uint32_t cells_of_brick(BrickPattern::Bond bond) {
  return bond == BrickPattern::Bond::kStack ? 1 : bond == BrickPattern::Bond::kHalf ? 2 : 3;
}

/// The lattice of the bricks of a box: length, height and depth of one, along the longer of x and z, along y, and
/// along the other. What it is to fill whole bricks of about that size do, or bricks of exactly that size cover it.
class Courses {
 public:
  Courses(const Box& box, const Vec3d& brick, BrickPattern::Bond bond, bool exactly);

  double cells() const { return product(d_); }
  /// Adds the bricks that meet the triangles of these parts (of task.solid), or whose middles lie in the solid. What a
  /// cell holds by less than a fiftieth of its sides belongs to its neighbours: where a wall's face and its bricks
  /// agree but for rounding no further bricks are laid. Linear in triangles + cells, and in the cells that the box of
  /// each triangle overlaps. Throws Interrupted.
  void lay(const Task& task, ColumnSampler& sampler, const std::vector<bool>& of_parts, double jitter,
           Random& random, Bricks& bricks) const;

 private:
  std::vector<bool> cells_met(const Task& task, ColumnSampler& sampler,
                              const std::vector<bool>& of_parts) const;
  std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (static_cast<std::size_t>(z) * d_[1].count + y) * d_[0].count + x;
  }

  std::array<Division, 3> d_;
  int along_;
  std::uint32_t split_;
};

}  // namespace fracture::sites_detail
