// Normals of rough caps: smooth within a cut, with creases between cuts.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/caps.hpp"

namespace fracture {

/// Returns the unit normal of each corner of every cap triangle, outward from cell lo. It is the mean,
/// weighted by area, over the triangles of the same cut at that place: the regions between the same two
/// owners whose facets face the same way. If the mean points behind the corner's triangle, the triangle's
/// normal is used.
std::vector<Vec3f> cap_normals(const VoronoiDiagram& diagram, const std::vector<std::uint32_t>& owner_of_site,
                               const Caps& caps, const VertexPositions& positions,
                               const Execution& execution);

}  // namespace fracture
