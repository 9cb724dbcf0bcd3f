// A convex polyhedron that is cut by planes one after the other (Sutherland & Hodgman 1974, face by face; the rim closes
// the cut). Whether a corner is kept is decided once for each plane. So the surface stays closed, unless rounding makes a
// plane pass a corner twice. The caller must check that (bounds_a_body).
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
  }  ///< after a cut, only those that a face still uses
  /// The largest distance of a corner beyond the plane, in lengths of the normal. If <= 0, the cut would change nothing.
  double beyond(const Vec3d& normal, double offset) const;
  /// Keeps the part with normal · x <= offset. Corners at most `rounding` (in lengths of the normal) off the plane count as on
  /// it, so a plane that grazes a face leaves it whole.
  void cut(const Vec3d& normal, double offset, double rounding);

  /// Returns corners and triangles, counter-clockwise from outside. Both are empty if nothing is left.
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
    std::uint32_t lo, hi, corner;  ///< the corner at the cut of the edge (lo, hi)
  };
  std::uint32_t cut_edge(std::uint32_t kept, std::uint32_t gone, double rounding);

  std::vector<Vec3d> points_;
  std::vector<std::uint32_t> corners_, begin_;  // of the faces in order
  std::vector<double> height_;                  // per corner, above the plane
  std::vector<Made> made_;
  std::vector<std::uint32_t> next_;  // per corner: the next one on the rim of the cut
  std::vector<std::uint32_t> new_corners_, new_begin_, number_;
};

}  // namespace fracture
