// Adds attributes that a material needs but the file does not have: texture coordinate sets that a material
// names, and a tangent frame for normal maps. They are added once, to the source, so that cutting
// interpolates them like other attributes and the output is valid. Colours are clamped to [0, 1], the range
// that the file format permits.
#pragma once

#include "common/mesh/mesh.hpp"

namespace fracture {

/// Adds a remark to `mesh.remarks` about each kind of attribute that was added.
void complete_attributes(Mesh& mesh);

/// Computes tangents for the triangles whose material is marked, from their positions and the material's UV
/// set (kNoIndex: not marked). Other wedges are unchanged. Method: Lengyel 2001, "Computing Tangent Space
/// Basis Vectors for an Arbitrary Mesh". The tangent is the direction of increasing u, averaged by area over
/// the triangles at a wedge, and made perpendicular to the normal. w is the side of the texture's up
/// direction (decreasing v), as in glTF's normal maps. A wedge without usable UVs gets zero. Requires
/// normals.
void compute_tangents(Mesh& mesh, const std::vector<std::uint32_t>& uv_set_of_material);

}  // namespace fracture
