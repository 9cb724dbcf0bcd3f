// A box cut in two by hand: everything a FracturedSolid can hold, with figures known from outside.
#pragma once

#include "common/pipeline/fractured_solid.hpp"

namespace fracture::test {

/// The box [0,2]x[0,1]x[0,1] cut at x = 1. Materials: "wood" (normal map, faces with z = const) and "paint"
/// (the other outside faces), normals, tangents, two UV sets, colours. Pivots are the centres (0.5, 0.5, 0.5)
/// and (1.5, 0.5, 0.5). One bond of area 1 at (1, 0.5, 0.5).
FracturedSolid two_halves();

/// The same with collision hulls, boxes with sides of 0.999: one for the first half, two (y < 0 and y > 0)
/// for the second.
FracturedSolid two_halves_with_hulls();

}  // namespace fracture::test
