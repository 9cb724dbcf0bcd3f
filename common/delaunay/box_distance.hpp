// Distances from points to a box, which show which sites own no point of the box.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/base/vec.hpp"

namespace fracture::delaunay_detail {

/// Squared distances from p to the nearest and the farthest point of the box.
inline double nearest2(const Box& box, const Vec3d& p) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    const double off = std::max({box.min[a] - p[a], p[a] - box.max[a], 0.0});
    sum += off * off;
  }
  return sum;
}
inline double farthest2(const Box& box, const Vec3d& p) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    const double off = std::max(std::fabs(p[a] - box.min[a]), std::fabs(p[a] - box.max[a]));
    sum += off * off;
  }
  return sum;
}

/// Whether a site may own a point in the box; both arguments are squared distances. If a site is farther from
/// the box than some other site's farthest point of the box, it owns no point in it. The margin makes the
/// decision safe from rounding errors; keeping a site needlessly only costs time.
inline bool is_near_enough(double nearest2, double reach2) { return nearest2 <= reach2 * (1 + 0x1p-40); }

}  // namespace fracture::delaunay_detail
