// A solid seen through a linear map: what decides an anisotropic fracture.
#pragma once

#include "common/base/execution.hpp"
#include "common/base/matrix3.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The same surface (vertex, triangle, edge and part ids) with its vertices at map · position, rounded once
/// to float; boxes, volumes, areas and layers are those of the image. Has no source, wedges, materials or
/// repair figures. Rounding may make triangles flat or fold over one another: the surface stays closed.
/// The map's determinant must be positive.
Solid image_of(const Solid& solid, const Matrix3& map, const Execution& execution = {});

}  // namespace fracture
