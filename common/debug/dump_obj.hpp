// Writes any stage of the pipeline as Wavefront OBJ, for viewing in any viewer. The text goes to a stream of
// the caller. Positions have enough digits to read back as the same float.
#pragma once

#include <iosfwd>

#include "common/delaunay/tetrahedralization.hpp"
#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"
#include "common/solid/solid.hpp"

namespace fracture::debug {

/// Writes one object per source node, and one material slot name ("slot_3", "none") per run of triangles.
void dump_obj(std::ostream& out, const Mesh& mesh);

/// Writes one object per part, and one group per shell. Filled triangles have the material "interior".
void dump_obj(std::ostream& out, const Solid& solid);

/// Writes one octahedron of this radius per site.
void dump_obj_of_sites(std::ostream& out, const Tetrahedralization& t, double radius);

/// Writes every tetrahedron of four sites as a separate solid. Its vertices are moved towards its middle by
/// `shrink` times their distance, so that neighbours can be distinguished. Tetrahedra at the big
/// tetrahedron's corners, which extend far beyond the mesh, are left out.
void dump_obj(std::ostream& out, const Tetrahedralization& t, double shrink);

/// Writes one object per fragment in world space, moved outwards from the centre of all fragments by
/// `explode` times its distance (0: not moved). Cut faces have the material "interior".
void dump_obj(std::ostream& out, const FragmentSet& set, double explode = 0);

}  // namespace fracture::debug
