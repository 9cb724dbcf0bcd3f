// The points of a convex hull, rounded to a grid of 2^19 steps along each side of their box: integers, kept as
// doubles. Normals of triangles are exact there, heights above a triangle nearly so, and exact in 64 bits
// where their sign hangs on it. The grid is 2e-6 of the box, far below what collision_hulls.hpp takes away.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/base/vec.hpp"

namespace fracture {

class HullGrid {
 public:
  /// What a height may be off by: six products below 2^58 are each rounded by 2^4 at most, five sums below
  /// 2^61 by 2^7.
  static constexpr double kHeightError = 1024;
  /// Of the box, in steps: components of normals stay below 2^39, their products with points below 3 * 2^58.
  static constexpr double kSide = 524287;  // 2^19 - 1

  /// dot(normal, x) = offset; the normal is exact, its components are below 2^39.
  struct Plane {
    Vec3d normal;
    double offset;
  };

  /// Two planes side by side: heights above both take as long as above one.
  struct PlanePair {
    using Pair = double __attribute__((vector_size(16)));  // g++ and clang++, of any processor
    Pair x, y, z, offset;
    void set(std::size_t side, const Plane& plane) {
      x[side] = plane.normal.x;
      y[side] = plane.normal.y;
      z[side] = plane.normal.z;
      offset[side] = plane.offset;
    }
    /// As height() has them, bit for bit.
    Pair heights(const Vec3d& p) const { return x * p.x + y * p.y + z * p.z - offset; }
  };
  void round(std::span<const Vec3f> points, Pacer& pacer);

  /// Only these, ascending, in their order.
  void keep(std::span<const std::uint32_t> points) {
    for (std::size_t k = 0; k < points.size(); ++k) points_[k] = points_[points[k]];
    points_.resize(points.size());
  }

  std::uint32_t size() const { return static_cast<std::uint32_t>(points_.size()); }
  const Vec3d& operator[](std::uint32_t p) const { return points_[p]; }

  /// Of the triangle (a, b, c), counter-clockwise from above.
  Plane plane(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3d &p = points_[a], normal = cross(points_[b] - p, points_[c] - p);
    return {normal, dot(normal, p)};
  }
  /// Twice the triangle's area times the height of p above it, to kHeightError.
  double height(const Plane& plane, std::uint32_t p) const {
    return dot(plane.normal, points_[p]) - plane.offset;
  }
  /// The same without error; `on`: a corner of the triangle.
  std::int64_t exact_height(const Vec3d& normal, std::uint32_t on, std::uint32_t p) const {
    const Vec3d d = points_[p] - points_[on];
    return static_cast<std::int64_t>(normal.x) * static_cast<std::int64_t>(d.x) +
           static_cast<std::int64_t>(normal.y) * static_cast<std::int64_t>(d.y) +
           static_cast<std::int64_t>(normal.z) * static_cast<std::int64_t>(d.z);
  }
  bool less(std::uint32_t a, std::uint32_t b) const { return lexicographic_less(points_[a], points_[b]); }

  /// Four extreme points that span a volume, the fourth below the triangle of the others; nothing where all
  /// are flat (within four steps).
  std::optional<std::array<std::uint32_t, 4>> first_tetrahedron(Pacer& pacer) const;

  std::size_t bytes() const { return bytes_of_vectors(points_); }
  void release() { release_vectors(points_); }

 private:
  std::vector<Vec3d> points_;
};

}  // namespace fracture
