// Tells which vertices of a surface are inside another part.
#pragma once

#include <cstdint>
#include <vector>

#include "common/contacts/moved_signs.hpp"
#include "common/contacts/near_triangles.hpp"

namespace fracture::contacts_detail {

/// The part's winding number at the point, which belongs to `owner`, the other part. It is computed from the triangles
/// through which a ray along +x passes. An embedded surface has winding number 1 inside and 0 outside.
/// common/solid/winding.hpp does the same, but needs a point that is not on the surface.
int winding_around(const PartSurfaces& surfaces, std::uint32_t part, const Vec3d& point, Owner owner,
                   Pacer& pacer);

/// By how much the other part's winding number grows from the beginning of each edge to its end.
using EdgeJumps = std::array<std::int32_t, 3>;

/// The winding number of the part `around` at the corners of the triangles. These are all triangles of the other part,
/// `owner`, that meet the box of `around`. `jumps` (per triangle) gives the differences along edges, so one number for each
/// connected piece of surface is enough: 0 outside the box, otherwise that of one ray.
std::vector<std::array<int, 3>> corner_windings(const PartSurfaces& surfaces,
                                                const std::vector<NearTriangle>& triangles,
                                                const std::vector<EdgeJumps>& jumps, std::uint32_t around,
                                                Owner owner, Pacer& pacer);

}  // namespace fracture::contacts_detail
