// Area and direction of a shared cap.
#pragma once

#include <cmath>

#include "common/clip/restricted_diagram.hpp"

namespace fracture {

/// Measures the triangles of one region. The area of a flat cap is its own. The area of a rough cap is
/// measured after projection onto the plane of the cut, so that relief does not make a bond stronger. Each
/// triangle counts with its absolute area and faces from cell lo to cell hi. If a surface crosses itself,
/// some triangles of a cap have the opposite orientation, and signed areas in the same bond would cancel.
class CapArea {
 public:
  CapArea(const RestrictedDiagram& diagram, const CapRegion& region)
      : d_(diagram),
        rough_(diagram.positions.are_rough()),
        across_(diagram.diagram.facet_normal(region.lo, region.hi)),
        width_(rough_ ? length(across_) : 1) {}

  struct Measured {
    double area;        ///< m²
    Vec3d normal;       ///< its length is the area of the triangle itself
    Vec3d corners_sum;  ///< three times its centroid
  };
  Measured of(std::uint32_t triangle) const {
    const auto& v = d_.caps.triangles[triangle];
    const Vec3d a = d_.point(v[0]), b = d_.point(v[1]), c = d_.point(v[2]);
    const Vec3d n = 0.5 * cross(b - a, c - a);
    const double along = dot(n, across_);
    return {rough_ ? std::fabs(along / width_) : length(n), along < 0 ? -1.0 * n : n, a + b + c};
  }

 private:
  const RestrictedDiagram& d_;
  const bool rough_;
  const Vec3d across_;
  const double width_;
};

}  // namespace fracture
