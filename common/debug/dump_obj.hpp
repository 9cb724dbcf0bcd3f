// Any stage of the pipeline as a Wavefront OBJ, to look at in any viewer. Text goes to a stream of the
// caller's; positions are written with the digits that read back as the same float.
#pragma once

#include <iosfwd>

#include "common/delaunay/tetrahedralization.hpp"
#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"
#include "common/solid/solid.hpp"

namespace fracture::debug {

/// One object for each source node, one material slot name ("slot_3", "none") for each run of triangles.
void dump_obj(std::ostream& out, const Mesh& mesh);

/// One object for each part, one group for each shell; filled triangles have the material "interior".
void dump_obj(std::ostream& out, const Solid& solid);

/// One octahedron of this radius for each site.
void dump_obj_of_sites(std::ostream& out, const Tetrahedralization& t, double radius);

/// Every tetrahedron of four sites as a solid of its own, its vertices moved towards its middle by `shrink`
/// times their distance, so that neighbours can be told apart. Those at the big tetrahedron's corners, which
/// reach far beyond the mesh, are left out.
void dump_obj(std::ostream& out, const Tetrahedralization& t, double shrink);

/// One object for each fragment in world space, moved outwards from the centre of all fragments by `explode`
/// times its distance (0: in place); cut faces have the material "interior".
void dump_obj(std::ostream& out, const FragmentSet& set, double explode = 0);

}  // namespace fracture::debug
