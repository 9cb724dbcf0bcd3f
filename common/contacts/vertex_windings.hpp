// Finds which vertices of a surface are inside another part.
#pragma once

#include <cstdint>
#include <vector>

#include "common/contacts/moved_signs.hpp"
#include "common/contacts/near_triangles.hpp"

namespace fracture::contacts_detail {

/// Returns the part's winding number at a point that belongs to the other part, `owner`. It is computed
/// from the triangles that a ray along +x passes through. An embedded surface has winding number 1 inside
/// and 0 outside. common/solid/winding.hpp does the same, but needs a point that is not on the surface.
int winding_around(const PartSurfaces& surfaces, std::uint32_t part, const Vec3d& point, Owner owner,
                   Pacer& pacer);

/// Change of the other part's winding number from the beginning of each edge to its end.
using EdgeJumps = std::array<std::int32_t, 3>;

/// Returns the winding numbers of the part `around` at the triangles' corners. The triangles are all those
/// of the other part, `owner`, that meet the box of `around`. `jumps` (per triangle) gives the differences
/// along edges, so one number per connected piece of surface is enough. It is 0 at a vertex outside the
/// box. If the piece has no such vertex, one ray is cast.
std::vector<std::array<int, 3>> corner_windings(const PartSurfaces& surfaces,
                                                const std::vector<NearTriangle>& triangles,
                                                const std::vector<EdgeJumps>& jumps, std::uint32_t around,
                                                Owner owner, Pacer& pacer);

}  // namespace fracture::contacts_detail
