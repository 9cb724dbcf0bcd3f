// The direction in which a symmetric matrix is largest: the first eigenvector, by repeated squaring, from + - * / and
// sqrt alone.
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

}  // namespace fracture
