#include "common/pipeline/hit_region.hpp"

#include <cmath>

#include "common/sites/sites.hpp"

namespace fracture {
namespace {

/// A site this near to the region, in steps of the site lattice, counts as inside: rounding its companion would turn the plane
/// between them too far.
constexpr double kLeastSteps = 2;
/// Companions are rounded to this share of the lattice's step. It is a power of two, so an image at a facet along the axes is exact.
constexpr double kCompanionStep = 0x1p-8;
/// A companion stays in this share of the line through the region.
constexpr double kWithin = 0.5;

Region with_margin(Region region, double margin) {
  region.radius += margin;
  region.box.min = region.box.min - Vec3d{margin, margin, margin};
  region.box.max = region.box.max + Vec3d{margin, margin, margin};
  return region;
}

}  // namespace

HitRegion::HitRegion(const Region& region, double margin, const SeenSolid& seen)
    : space_(with_margin(region, margin), seen), step_(site_lattice(seen.seen().box).step) {}

void HitRegion::leave_out_inside(std::vector<Vec3d>& sites) const {
  std::erase_if(sites, [&](const Vec3d& s) { return space_.depth(s) > -kLeastSteps * step_; });
}

Vec3d HitRegion::companion(const Vec3d& site) const {
  const std::vector<KeptFacet>& facets = space_.at(site).facets;
  const KeptFacet* nearest = &facets[0];  // the facet that the site is farthest beyond
  for (const KeptFacet& facet : facets)
    if (facet.depth(site) < nearest->depth(site)) nearest = &facet;
  const Vec3d& n = nearest->normal;
  const double h = -nearest->depth(site);
  // The line from the site along -n is inside between the distances `enter` and `leave`, if enter < leave.
  double enter = h, leave = HUGE_VAL;
  for (const KeptFacet& facet : facets) {
    const double towards = dot(facet.normal, n), depth = facet.depth(site);
    if (towards > 0) enter = std::fmax(enter, -depth / towards);
    if (towards < 0) leave = std::fmin(leave, -depth / towards);
    if (towards == 0 && depth < 0) leave = -HUGE_VAL;
  }
  double t = h;
  if (enter < leave) t = std::fmin(t, enter - h + kWithin * (leave - enter));
  const SiteLattice lattice{kCompanionStep * step_};
  return lattice.snap(site - (h + t) * n);
}

}  // namespace fracture
