// Volume and moments of the region that triangles enclose. They show the direction in which a part is long or
// thin.
#pragma once

#include <cmath>

#include "common/base/matrix3.hpp"
#include "common/base/vec.hpp"
#include "common/sites/arithmetic.hpp"

namespace fracture::sites_detail {

/// Volume (m³), and first and second moments about the origin.
struct Moments {
  double volume = 0;
  Vec3d first;
  Matrix3 second{{Vec3d{}, Vec3d{}, Vec3d{}}};

  /// Adds the tetrahedron from the origin: the integral of x xᵀ is det / 120 (s sᵀ + a aᵀ + b bᵀ + c cᵀ), s =
  /// a + b + c.
  void add(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const double det = dot(a, cross(b, c));
    const Vec3d s = a + b + c;
    volume += det / 6;
    first = first + (det / 24) * s;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        second.rows[static_cast<std::size_t>(i)][j] +=
            det / 120 * (s[i] * s[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]);
  }
  /// The second moments about the centre of mass.
  Matrix3 central() const {
    Matrix3 m = second;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m.rows[static_cast<std::size_t>(i)][j] -= first[i] * first[j] / volume;
    return m;
  }
};

/// Returns the unit vector without small components that come from rounding or noise in the model.
inline Vec3d without_noise(Vec3d axis) {
  constexpr double kNoise = 1e-4;
  for (int k = 0; k < 3; ++k)
    if (std::fabs(axis[k]) < kNoise) axis[k] = 0;
  return normalized(axis);
}

}  // namespace fracture::sites_detail
