// A box cut in two by hand. It contains everything that a FracturedSolid can hold, with figures known from
// outside.
#pragma once

#include "common/pipeline/fractured_solid.hpp"

namespace fracture::test {

/// The box [0,2]x[0,1]x[0,1], cut at x = 1. Its materials are "wood" (normal map, faces with z = const) and
/// "paint" (the other outside faces). It has normals, tangents, two UV sets and colours. The pivots are the
/// centres (0.5, 0.5, 0.5) and (1.5, 0.5, 0.5). There is one bond of area 1 at (1, 0.5, 0.5).
FracturedSolid two_halves();

/// The same box with collision hulls, which are boxes with sides of 0.999. The first half has one hull, the
/// second has two (y < 0 and y > 0).
FracturedSolid two_halves_with_hulls();

}  // namespace fracture::test
