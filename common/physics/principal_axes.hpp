// The inertia tensor in the form that physics engines need: three moments and a rotation.
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
/// & Van Loan, Matrix Computations, 8.5). It uses only + - * / and sqrt, so the bits are the same everywhere. Tiny
/// negative moments, which rounding causes, become 0.
PrincipalAxes principal_axes(const std::array<double, 6>& inertia);

/// Inertia of the fragment about its centre of mass, at 1 kg/m³. If the surface crosses itself, parts of the volume count
/// as negative, and the tensor may be physically impossible. (For engines, a moment of 0 means that a body never turns.)
/// If the fragment has no volume, the tensor consists of rounding errors. Both kinds of fragments get the inertia of a solid box
/// with their extent and mass instead.
PrincipalAxes body_inertia(const Fragment& f);

/// m³, more than 0: the fragment's volume as answers state it. It is the volume before rounding, if positive. A sliver may
/// have 0 or less; then it is the volume of the positions in the file. That may not be positive either, if a sheet was
/// filled flat or the surface crosses itself. Then it is half of the surface's area times a millionth of the longest side,
/// because a mass of 0 means to engines that a body never moves.
double body_volume(const Fragment& f);

}  // namespace fracture
