// The source paper's look: the cell of a site is the convex hull (Quickhull, Barber et al. 1996, through the
// Qhull library) of the barycentres, instead of the circumcentres, of the tetrahedra around it. Such cells
// overlap and leave gaps: they are no partition of space.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

/// Of a cell with more tetrahedra around it only so many barycentres count, evenly spread over their
/// lexicographic order: the time of Quickhull grows with the square of their number where they lie on a few
/// curves (1,024 on two circles: 11 ms, 40,000: half a minute), and it cannot be interrupted.
inline constexpr std::size_t kMostBarycenters = 1024;

/// The hull as a Voronoi cell: sites[0] is the mean of the barycentres, the others are its mirror images
/// across the planes of the hull's facets, so that the Voronoi cell of sites[0] among them *is* the hull (up
/// to the rounding of the images). This way the exact clipper cuts these cells too. Nothing where the hull is
/// flat or degenerate.
std::optional<std::vector<Vec3d>> barycentric_cell(const VoronoiDiagram& diagram, SiteId i);

}  // namespace fracture
