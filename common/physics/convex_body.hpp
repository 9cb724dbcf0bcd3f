// A convex polyhedron that is cut by planes, one after the other (Sutherland & Hodgman 1974, face by face, and the cut
// closed by its rim). Which corners are kept is decided once for each plane and corner: the surface stays closed, but
// where, within rounding, a plane passes a corner twice. The caller looks (bounds_a_body).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/scratch.hpp"
#include "common/base/vec.hpp"

namespace fracture {

class ConvexBody {
 public:
  /// Triangles of indices into `points`, counter-clockwise from outside.
  void set(std::span<const Vec3f> points, std::span<const std::array<std::uint32_t, 3>> triangles);

  std::span<const Vec3d> corners() const {
    return points_;
  }  ///< after a cut those that are kept, and no others
  /// How far a corner lies beyond the plane, in lengths of the normal, at most; <= 0: the cut would change nothing.
  double beyond(const Vec3d& normal, double offset) const;
  /// Keeps what has normal · x <= offset. Corners that are no more than `rounding` (in lengths of the normal) off the plane
  /// lie on it: a plane that grazes a face leaves it whole.
  void cut(const Vec3d& normal, double offset, double rounding);

  /// Corners and triangles, counter-clockwise from outside; nothing where nothing is left.
  void write(std::vector<Vec3f>& points, std::vector<std::array<std::uint32_t, 3>>& triangles) const;

  std::size_t bytes() const {
    return bytes_of_vectors(points_, corners_, begin_, height_, made_, next_, new_corners_, new_begin_,
                            number_);
  }
  void release() {
    release_vectors(points_, corners_, begin_, height_, made_, next_, new_corners_, new_begin_, number_);
  }

 private:
  struct Made {
    std::uint32_t lo, hi, corner;  ///< where the edge (lo, hi) was cut
  };
  std::uint32_t cut_edge(std::uint32_t kept, std::uint32_t gone, double rounding);

  std::vector<Vec3d> points_;
  std::vector<std::uint32_t> corners_, begin_;  // of the faces, one after the other
  std::vector<double> height_;                  // per corner, above the plane
  std::vector<Made> made_;
  std::vector<std::uint32_t> next_;  // per corner: the next one on the rim of the cut
  std::vector<std::uint32_t> new_corners_, new_begin_, number_;
};

}  // namespace fracture
