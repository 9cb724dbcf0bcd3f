// The outer surface of a solid as a uniform grid of triangles: how far it is from a point nearby, and which
// of its triangles are near a box.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/solid/solid.hpp"

namespace fracture {

/// Distance from p to the triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5: the regions of its
/// corners, edges and face).
double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

/// A box divided into cubes of at least the asked width: wider ones where there would be too many.
class UniformGrid {
 public:
  UniformGrid(const Box& box, double least_width);
  double width() const { return width_; }
  std::size_t size() const { return static_cast<std::size_t>(count_[0] * count_[1] * count_[2]); }
  using Cell = std::array<std::int64_t, 3>;
  /// Of points beyond the box: the nearest at its border.
  Cell cell_of(const Vec3d& p) const {
    Cell cell;
    for (int a = 0; a < 3; ++a) {
      const double at = std::floor((p[a] - origin_[a]) / width_);
      const auto last = static_cast<double>(count_[static_cast<std::size_t>(a)] - 1);
      cell[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(std::fmin(std::fmax(at, 0), last));
    }
    return cell;
  }
  std::size_t index(const Cell& c) const {
    return static_cast<std::size_t>((c[2] * count_[1] + c[1]) * count_[0] + c[0]);
  }
  Vec3d middle(const Cell& c) const {
    return {origin_.x + (static_cast<double>(c[0]) + 0.5) * width_,
            origin_.y + (static_cast<double>(c[1]) + 0.5) * width_,
            origin_.z + (static_cast<double>(c[2]) + 0.5) * width_};
  }
  /// visit(cell) for those from the cell of `low` to that of `high`.
  template <class Visit>
  void each_cell(const Vec3d& low, const Vec3d& high, const Visit& visit) const {
    const Cell from = cell_of(low), to = cell_of(high);
    for (std::int64_t z = from[2]; z <= to[2]; ++z)
      for (std::int64_t y = from[1]; y <= to[1]; ++y)
        for (std::int64_t x = from[0]; x <= to[0]; ++x) visit(Cell{x, y, z});
  }

 private:
  Vec3d origin_;
  double width_;
  Cell count_{};
};

class SurfaceGrid {
 public:
  /// For distances up to `reach` (> 0, m). Linear in the triangles and the cells they touch.
  SurfaceGrid(const Solid& solid, double reach);

  /// min(distance from p to the surface, reach), m.
  double distance(const Vec3d& p) const;
  /// visit(triangle) for every one that meets the box, and others near it; some more than once.
  template <class Visit>
  void each_near(const Box& box, const Visit& visit) const {
    grid_.each_cell(box.min, box.max, [&](const UniformGrid::Cell& cell) {
      const std::size_t c = grid_.index(cell);
      for (std::uint32_t k = begin_[c]; k < begin_[c + 1]; ++k) visit(triangles_[k]);
    });
  }
  std::array<Vec3d, 3> corners(std::uint32_t triangle) const {
    const auto& t = solid_.triangles[triangle];
    return {to_double(solid_.positions[t[0]]), to_double(solid_.positions[t[1]]),
            to_double(solid_.positions[t[2]])};
  }

 private:
  const Solid& solid_;
  const double reach_;
  UniformGrid grid_;
  std::vector<std::uint32_t> begin_, triangles_;  // of each cell, those that may meet it
  std::vector<bool> nearby_;                      // per cell: a triangle may be within reach of its points
};

}  // namespace fracture
