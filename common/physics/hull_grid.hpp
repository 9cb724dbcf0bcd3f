// The points of a convex hull, rounded to a grid of 2^19 steps along each side of their box. They are integers stored
// as doubles. Normals of triangles are exact, and heights above a triangle nearly so. If a height is too small for its
// sign to be certain, it is computed exactly in 64 bits. A step is 2e-6 of the box, far less than the inset of a hull.
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
  /// Maximum error of a height: six products below 2^58 are each rounded by at most 2^4, and five sums below
  /// 2^61 by at most 2^7.
  static constexpr double kHeightError = 1024;
  /// Side of the box in steps. Components of normals stay below 2^39, and their products with points below 3 * 2^58.
  static constexpr double kSide = 524287;  // 2^19 - 1

  /// dot(normal, x) = offset. The normal is exact; its components are below 2^39.
  struct Plane {
    Vec3d normal;
    double offset;
  };

  /// Two planes in vector registers: computing heights above both takes as long as above one.
  struct PlanePair {
    using Pair = double __attribute__((vector_size(16)));  // g++ and clang++, on any processor
    Pair x, y, z, offset;
    void set(std::size_t side, const Plane& plane) {
      x[side] = plane.normal.x;
      y[side] = plane.normal.y;
      z[side] = plane.normal.z;
      offset[side] = plane.offset;
    }
    /// Returns the same bits as height().
    Pair heights(const Vec3d& p) const { return x * p.x + y * p.y + z * p.z - offset; }
  };
  void round(std::span<const Vec3f> points, Pacer& pacer);

  /// Removes all points but these. The indices must be ascending.
  void keep(std::span<const std::uint32_t> points) {
    for (std::size_t k = 0; k < points.size(); ++k) points_[k] = points_[points[k]];
    points_.resize(points.size());
  }

  std::uint32_t size() const { return static_cast<std::uint32_t>(points_.size()); }
  const Vec3d& operator[](std::uint32_t p) const { return points_[p]; }

  /// Returns the plane of the triangle (a, b, c), which is counter-clockwise from above.
  Plane plane(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3d &p = points_[a], normal = cross(points_[b] - p, points_[c] - p);
    return {normal, dot(normal, p)};
  }
  /// Twice the triangle's area times the height of p above it, with an error of at most kHeightError.
  double height(const Plane& plane, std::uint32_t p) const {
    return dot(plane.normal, points_[p]) - plane.offset;
  }
  /// The same without error. `on`: a corner of the triangle.
  std::int64_t exact_height(const Vec3d& normal, std::uint32_t on, std::uint32_t p) const {
    const Vec3d d = points_[p] - points_[on];
    return static_cast<std::int64_t>(normal.x) * static_cast<std::int64_t>(d.x) +
           static_cast<std::int64_t>(normal.y) * static_cast<std::int64_t>(d.y) +
           static_cast<std::int64_t>(normal.z) * static_cast<std::int64_t>(d.z);
  }
  bool less(std::uint32_t a, std::uint32_t b) const { return lexicographic_less(points_[a], points_[b]); }

  /// Returns four extreme points that span a volume; the fourth is below the triangle of the others. Returns nothing if all
  /// points are flat (within four steps).
  std::optional<std::array<std::uint32_t, 4>> first_tetrahedron(Pacer& pacer) const;

  std::size_t bytes() const { return bytes_of_vectors(points_); }
  void release() { release_vectors(points_); }

 private:
  std::vector<Vec3d> points_;
};

}  // namespace fracture
