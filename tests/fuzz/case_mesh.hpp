// The mesh of a case: shapes that touch, overlap or are open, damaged, scaled and moved.
#pragma once

#include <string>
#include <vector>

#include "tests/fuzz/fracture_case.hpp"

namespace fracture::fuzz {

/// The box of the vertices that triangles use.
Box box_of(const Mesh& mesh);

/// Makes a mesh with two materials. Adds to `words` how it was made, and to `sites` the sites that belong to its family of shapes.
Mesh mesh_of(Bytes& bytes, std::string& words, std::vector<Vec3d>& sites);

}  // namespace fracture::fuzz
