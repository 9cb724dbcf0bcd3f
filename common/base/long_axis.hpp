// The directions in which a symmetric matrix is largest and smallest: its first and last eigenvectors.
// Computed by repeated squaring, using only + - * / and sqrt.
#pragma once

#include <optional>

#include "common/base/matrix3.hpp"

namespace fracture {

struct LongAxis {
  Vec3d axis;    ///< unit vector, of either sign
  double ratio;  ///< largest eigenvalue / next eigenvalue, at least 1
};

/// For a positive semidefinite matrix. None if it is zero or not finite. If the ratio is near 1, the axis is
/// arbitrary.
std::optional<LongAxis> long_axis(const Matrix3& symmetric);

struct ShortAxis {
  Vec3d axis;    ///< unit vector, of either sign
  double ratio;  ///< smallest eigenvalue / next eigenvalue, 0 to 1
};

/// Like long_axis(). If the ratio is near 1, the axis is arbitrary.
std::optional<ShortAxis> short_axis(const Matrix3& symmetric);

}  // namespace fracture
