// Bricks laid in courses, and a test for the bricks that meet a solid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/sites/division.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {

/// Bricks as sites: the cells of each brick are consecutive.
struct Bricks {
  struct Brick {
    Vec3d middle, half;   ///< in the image; half its sides
    std::uint32_t first;  ///< index of the first cell
  };
  std::vector<Vec3d> cells;
  std::vector<Brick> bricks;
  std::uint32_t end_of(std::size_t brick) const {
    return brick + 1 < bricks.size() ? bricks[brick + 1].first : static_cast<std::uint32_t>(cells.size());
  }
};

/// Number of cells in a brick: the shift between courses divides a brick into this many equal parts.
inline std::uint32_t cells_of_brick(BrickPattern::Bond bond) {
  return bond == BrickPattern::Bond::kStack ? 1 : bond == BrickPattern::Bond::kHalf ? 2 : 3;
}

/// The lattice of bricks in a box. Their length runs along the longer of x and z, their height along y, and
/// their depth along the remaining axis. By default, the bricks are resized so that a whole number fills the
/// box. With `exactly`, bricks of exactly the given size cover the box.
class Courses {
 public:
  Courses(const Box& box, const Vec3d& brick, BrickPattern::Bond bond, bool exactly);

  double cells() const { return product(d_); }
  /// Adds the bricks that meet the triangles of these parts (of task.solid) or whose middles are in the
  /// solid. A cell that the solid enters by less than a fiftieth of the cell's side is left to its
  /// neighbours. So if a wall's face coincides with a brick's face up to rounding, no extra bricks are laid.
  /// Linear in triangles + cells, and in the cells that overlap the box of each triangle. Throws Interrupted.
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
