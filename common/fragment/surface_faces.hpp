// Divides the input's triangles among owners and triangulates the parts.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

struct OwnedFaces {
  std::vector<std::uint32_t> begin;  ///< per owner, plus one entry
  std::vector<Face> faces;           ///< sorted by owner, then by input triangle
};

/// Divides the surface. A triangle within one owner is copied whole, bit for bit. A cell's convex polygon
/// is halved repeatedly into triangles. The polygons of one group within a triangle are fused, possibly
/// into a polygon with holes. Everything between them disappears: segments on bisectors inside the group, B
/// vertices between two of its cells, and C vertices between three. Near-linear, even in the number of
/// polygons in one triangle. Throws Interrupted.
OwnedFaces divide_surface(const RestrictedDiagram& diagram, const Ownership& ownership,
                          const Execution& execution = kUninterrupted);

}  // namespace fracture
