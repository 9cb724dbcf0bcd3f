// What a material needs and the file does not have is added once, on the source, so that cutting interpolates
// it like everything else and the output is valid: texture coordinate sets that a material names, and a
// tangent frame under normal maps. Colours are clamped to [0, 1], which is all the file format allows.
#pragma once

#include "common/mesh/mesh.hpp"

namespace fracture {

/// Adds to `mesh.remarks` what was made up.
void complete_attributes(Mesh& mesh);

/// Tangents for the triangles whose material is marked, from their positions and the UV set it names
/// (kNoIndex: not marked); other wedges keep what they have. Lengyel 2001, "Computing Tangent Space Basis
/// Vectors for an Arbitrary Mesh": the direction of growing u, averaged over the triangles at a wedge by
/// area, made perpendicular to the normal; w is the side on which the texture's up (falling v) lies, as
/// glTF's normal maps have it. A wedge without a usable UV gets zero. Needs normals.
void compute_tangents(Mesh& mesh, const std::vector<std::uint32_t>& uv_set_of_material);

}  // namespace fracture
