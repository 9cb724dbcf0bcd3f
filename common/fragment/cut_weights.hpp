// Weights with which a cut point interpolates the attributes of an edge or a triangle.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/vec.hpp"

namespace fracture {

/// Parameter of x on the segment (a, b), computed along the segment's longest axis. 0 if the segment has no length.
inline double along(const Vec3d& a, const Vec3d& b, const Vec3d& x) {
  const Vec3d e = b - a;
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::fabs(e[k]) > std::fabs(e[axis])) axis = k;
  if (e[axis] == 0) return 0;
  return std::clamp((x[axis] - a[axis]) / e[axis], 0.0, 1.0);
}

/// Barycentric coordinates of x in a triangle; 1, 0, 0 if the triangle has no area.
inline std::array<double, 3> barycentric(const std::array<Vec3d, 3>& triangle, const Vec3d& x) {
  const Vec3d a = triangle[0] - x, b = triangle[1] - x, c = triangle[2] - x;
  const Vec3d n = cross(b - a, c - a);
  std::array<double, 3> w{std::fmax(0, dot(n, cross(b, c))), std::fmax(0, dot(n, cross(c, a))),
                          std::fmax(0, dot(n, cross(a, b)))};
  const double sum = w[0] + w[1] + w[2];
  if (!(sum > 0)) return {1, 0, 0};
  for (double& k : w) k /= sum;
  return w;
}

}  // namespace fracture
