// The directions in which the vertices of an open sheet move to become the back of a slab.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// The direction in which a vertex moves, and how well it suits the triangles at the vertex.
struct SheetOffset {
  Vec3d normal;      ///< unit; 0 if there is none
  double least = 1;  ///< cosine of the largest angle between `normal` and the normal of a triangle
};

/// The position of `v` in `vertices`, which are ascending and contain it.
inline std::size_t index_of(VertexId v, const std::vector<VertexId>& vertices) {
  return static_cast<std::size_t>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
}

/// Returns the offset of each of `vertices` (ascending, all vertices of the front): the mean of the different normals of its
/// triangles. Each direction counts once, however many triangles have it. So a corner of a box has the same distance from its
/// three faces. `mitred` false: the mean of all normals, weighted by area, and no mitre. Throws Interrupted.
std::vector<SheetOffset> sheet_offsets(const Surface& surface, const std::vector<TriangleId>& front,
                                       const std::vector<VertexId>& vertices, bool mitred, Pacer& pacer);

}  // namespace fracture::solid_detail
