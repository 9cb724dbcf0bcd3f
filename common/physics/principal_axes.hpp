// The inertia tensor as physics engines want it: three moments and a rotation.
#pragma once

#include <array>

#include "common/base/vec.hpp"
#include "common/fragment/fragments.hpp"

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

/// Of the fragment about its centre of mass, at 1 kg/m³. Where the surface crosses itself parts of the volume
/// count negative and the tensor can be one that no body has (engines take a moment of 0 for a body that
/// never turns); where there is no volume it is that of rounding. Then that of a solid box of the fragment's extent
/// and mass.
PrincipalAxes body_inertia(const Fragment& f);

/// m³, more than 0: what answers say of the fragment. Its volume before rounding, if it has one; a sliver may have 0 or
/// less: then that of its positions in the file. A sheet that was filled flat, or whose surface crosses itself, may have
/// neither, and engines take a mass of 0 for a body that never moves: then that of half of its surface, a millionth of its
/// longest side thick.
double body_volume(const Fragment& f);

}  // namespace fracture
