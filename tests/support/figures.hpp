// Oracles: figures of a mesh computed by other means than the code under test.
#pragma once

#include <cstdint>

#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// Volume by the divergence theorem in long double, about the first vertex. Signed.
double volume_of(const Mesh& mesh);
double area_of(const Mesh& mesh);
Box box_of(const Mesh& mesh);

/// After welding equal positions: directed edges without as many uses in the opposite direction.
std::uint64_t open_directed_edges(const Mesh& mesh);

/// Winding number of the mesh around p: the sum of signed solid angles (van Oosterom & Strackee 1983) over
/// 4π, not rounded. Meaningful off the surface only.
double winding_number(const Mesh& mesh, const Vec3d& p);

}  // namespace fracture::test
