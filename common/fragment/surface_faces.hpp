// The input's triangles, divided among owners and triangulated.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

struct OwnedFaces {
  std::vector<std::uint32_t> begin;  ///< per owner + 1
  std::vector<Face> faces;           ///< by owner, then by input triangle
};

/// A triangle within one owner is copied whole, bit for bit. A cell's convex polygon is halved into
/// triangles. The polygons of one group within a triangle are fused (what lies between them disappears:
/// segments on bisectors inside the group, B vertices between two and C vertices between three of its cells),
/// possibly into a polygon with holes. Near-linear, also in the polygons of one triangle. Throws Interrupted.
OwnedFaces divide_surface(const RestrictedDiagram& diagram, const Ownership& ownership,
                          const Execution& execution = kUninterrupted);

}  // namespace fracture
