// The directions in which a symmetric matrix is largest and smallest: the first and the last eigenvector, by repeated
// squaring, from + - * / and sqrt alone.
#pragma once

#include <optional>

#include "common/base/matrix3.hpp"

namespace fracture {

struct LongAxis {
  Vec3d axis;    ///< of unit length, of either sign
  double ratio;  ///< of the largest eigenvalue to the next, at least 1
};

/// Of a positive semidefinite matrix; none of one that is zero or not finite. Where the ratio is near 1 the axis is any.
std::optional<LongAxis> long_axis(const Matrix3& symmetric);

struct ShortAxis {
  Vec3d axis;    ///< of unit length, of either sign
  double ratio;  ///< of the smallest eigenvalue to the next, 0 to 1
};

/// As long_axis(). Where the ratio is near 1 the axis is any.
std::optional<ShortAxis> short_axis(const Matrix3& symmetric);

}  // namespace fracture
