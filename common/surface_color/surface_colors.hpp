// Computes the mean colours of a mesh's triangles from the factors, textures and vertex colours of their
// materials. Cut faces use the colour of the surface that they were cut from (gltf/interior_material.hpp).
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Maximum numbers of decoded pixels. One image: `of_one`. All images of a mesh: `any` plus `per_byte` for
/// each of their bytes, but at most `most`.
struct PixelLimits {
  std::uint64_t of_one = 1u << 24, any = 1u << 24, per_byte = 64, most = 1u << 27;
};

/// Returns Mesh::triangle_color: the mean base colour of each triangle. It is sampled at up to 64 points, on
/// the level of a mean pyramid on which these points are some pixels apart. The colour is unknown if a
/// triangle has neither a material nor vertex colours, or if its image cannot be read (pixels.hpp) or is too
/// large; `remarks` names the material. Empty if no colour is known. The result is the same on every machine.
/// Throws std::bad_alloc.
std::vector<SurfaceColor> surface_colors(const Mesh& mesh, Remarks& remarks, const PixelLimits& limits = {});

}  // namespace fracture
