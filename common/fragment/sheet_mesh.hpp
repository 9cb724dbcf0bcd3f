// The mesh of a fragment's sheets.
#pragma once

#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Returns a mesh of faces of a cut sheet, about `pivot`. Corners with the same position and attributes are one
/// vertex. Vertices of the source keep their attributes, bit for bit; those at cuts are interpolated linearly, as
/// on the outside of a fragment. Triangles are sorted by material, then in the order of the faces. Throws
/// Interrupted.
Fragment sheet_mesh(const RestrictedDiagram& sheets, std::span<const Face> faces, const Vec3d& pivot,
                    const Execution& execution);

/// Returns the sheets of a fragment as a mesh in the source's frame, so that they can be cut further. `f.sheet`
/// must not be null. Throws Interrupted.
Mesh mesh_of_sheet(const FragmentSet& set, const Fragment& f, const Execution& execution);

}  // namespace fracture
