// Sites that make the surface of a kept region a boundary of cells.
//
// Let P be the region, a convex polyhedron. Sites A inside P and their mirror images B at the facets of P are
// added. A point of P is nearer to a site of A than to the site's mirror images. So if A and B are the only
// sites near the surface, the union of the cells of the sites in P is exactly P:
//
//   - Let r be a number such that each point of the surface has a site of A, and so one of B, within r.
//   - Let s be a site of the pattern outside P, at least r from it, and x a point of P. The segment from x to s
//     leaves P at a point z, so |x - s| >= |x - z| + r. Some site of A is within |x - z| + r of x, so s does not
//     own x. The same holds for a site inside, at least r from the surface, and a point outside. Sites nearer
//     than r are left out.
//   - Let x be outside and a the site of A that is nearest to x. The segment from a to x leaves P at a point z
//     of a facet F. No site of A is nearer to z, because it would be nearer to x. So if B contains the mirror
//     image of a at each facet that a's cell among A meets, x is nearer to one of them than to a.
//
// The projection of a site onto the solid's box is at least as near to each point of the box as the site. So the projection
// decides. If a site and its projection are on different sides of the surface, the site is left out.
#pragma once

#include <cstdint>

#include "common/base/execution.hpp"
#include "common/pipeline/kept_space.hpp"
#include "common/sites/pattern.hpp"

namespace fracture {

/// Adds the sites to a plan without hits, and leaves out sites near the surface (points of a PointsPattern are
/// moved to a site inside instead, so that numbers of points stay). Sets SitePlan::clearance to r. With
/// `grouped`, cells in the region are one group, and a cell outside stays with the cell of the pattern at whose
/// place it is, so the number of pieces does not grow. The added sites do not count towards most_sites; there
/// are a few thousand at most. Near-linear in sites. Throws Interrupted.
void add_keep_sites(const KeptSpace& space, const SeenSolid& seen, bool grouped, bool keeps_numbers,
                    SitePlan& plan, const Execution& execution);

/// Whether a further site at this place leaves the surface of the region as it is, and does not divide it.
/// `clearance`: SitePlan::clearance.
bool may_have_site(const KeptSpace& space, const Vec3d& image, double clearance);

}  // namespace fracture
