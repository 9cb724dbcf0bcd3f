// Oracles: figures of a mesh, computed by other methods than the code under test.
#pragma once

#include <cstdint>

#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// The signed volume by the divergence theorem in long double, about the first vertex.
double volume_of(const Mesh& mesh);
double area_of(const Mesh& mesh);
Box box_of(const Mesh& mesh);

/// The number of directed edges with fewer uses in the opposite direction, after welding equal positions.
std::uint64_t open_directed_edges(const Mesh& mesh);

/// The winding number of the mesh around p: the sum of signed solid angles (van Oosterom & Strackee 1983)
/// over 4π, not rounded. It is meaningful only off the surface.
double winding_number(const Mesh& mesh, const Vec3d& p);

}  // namespace fracture::test
