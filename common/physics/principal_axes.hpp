// The inertia tensor as physics engines want it: three moments and a rotation.
#pragma once

#include <array>

#include "common/base/vec.hpp"

namespace fracture {

struct PrincipalAxes {
  std::array<double, 3> moments{};  ///< kg·m², each >= 0
  std::array<double, 4> rotation{0, 0, 0,
                                 1};  ///< unit quaternion x, y, z, w: from principal axes to the body's frame
};

/// Diagonalizes the symmetric tensor (xx, yy, zz, xy, xz, yz) by cyclic Jacobi rotations (Jacobi 1846; Golub
/// & Van Loan, Matrix Computations, 8.5): only + - * / and sqrt, the same bits everywhere. Tiny negative
/// moments (rounding) become 0.
PrincipalAxes principal_axes(const std::array<double, 6>& inertia);

}  // namespace fracture
