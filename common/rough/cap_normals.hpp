// Normals of rough caps: smooth within a cut, creased between two.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/caps.hpp"

namespace fracture {

/// Per corner of every cap triangle the unit normal, outward for cell lo: the mean by area over the triangles
/// there of the same cut, that is, of the regions between the same two owners whose facets face the same way. Corners whose
/// mean would point behind their triangle have the triangle's normal instead.
std::vector<Vec3f> cap_normals(const VoronoiDiagram& diagram, const std::vector<std::uint32_t>& owner_of_site,
                               const Caps& caps, const VertexPositions& positions,
                               const Execution& execution);

}  // namespace fracture
