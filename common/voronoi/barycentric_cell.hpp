// The source paper's appearance: the cell of a site is the convex hull (Quickhull, Barber et al. 1996, with
// the Qhull library) of the barycentres, instead of the circumcentres, of the tetrahedra around it. Such
// cells overlap and leave gaps, so they are not a partition of space.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

/// Maximum number of barycentres of a cell. If there are more tetrahedra around it, only this many are used,
/// evenly spread over their lexicographic order. If the points are on a few curves, the time of Quickhull
/// grows with the square of their number (1,024 on two circles: 11 ms, 40,000: half a minute), and it cannot
/// be interrupted.
inline constexpr std::size_t kMostBarycenters = 1024;

/// Returns the hull as a Voronoi cell: sites[0] is the mean of the barycentres, and the others are its mirror
/// images across the planes of the hull's facets. So the Voronoi cell of sites[0] among them *is* the hull
/// (up to the rounding of the images), and the exact clipper can cut these cells too. Returns nothing if the
/// hull is flat or degenerate.
std::optional<std::vector<Vec3d>> barycentric_cell(const VoronoiDiagram& diagram, SiteId i);

}  // namespace fracture
