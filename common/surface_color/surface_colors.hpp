// What colour the triangles of a mesh have on the whole: factor, texture and vertex colours of their materials,
// as means. What is cut shows the colour of what it was cut from (gltf/interior_material.hpp).
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Most pixels that are looked at: of one image; and of all images of a mesh, so many of any and more for each of their
/// bytes, up to `most`.
struct PixelLimits {
  std::uint64_t of_one = 1u << 24, any = 1u << 24, per_byte = 64, most = 1u << 27;
};

/// For Mesh::triangle_color: the mean base colour of each triangle, at 64 places of it or fewer, from the level
/// of a mean pyramid on which these are some pixels apart. Not known where a triangle has neither a material nor vertex
/// colours, or its image cannot be read (pixels.hpp) or is too large; `remarks` says which image. Empty if no
/// colour is known. The result is the same on every machine. Throws std::bad_alloc.
std::vector<SurfaceColor> surface_colors(const Mesh& mesh, Remarks& remarks, const PixelLimits& limits = {});

}  // namespace fracture
