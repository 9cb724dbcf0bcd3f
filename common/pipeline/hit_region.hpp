// Keeps the cells of a hit out of a region to keep, so that the hit breaks everything around the region.
//
// Let P be the region, a convex polyhedron. Sites of the hit inside P are left out. Every other site s gets a companion s', which
// is a further guard (local_impact.hpp), so its cell belongs to the rest:
//
//          s   ·                F  the facet of P that s is farthest beyond, at the distance h; its normal n points out of P
//          |   ·  h             s' = s - (h + t) n, with 0 <= t <= h
//   -------+----------- F
//          |   ·  t             Points that are as near to s as to s' lie in a plane parallel to F, (h - t) / 2 outside it.
//   P      s'  ·                P lies on the other side of this plane, so the cell of s does not enter it.
//
// With t = h, the plane is F. t is smaller if s' would otherwise leave P on its far side, and take the space there from the hit.
#pragma once

#include <vector>

#include "common/pipeline/kept_space.hpp"

namespace fracture {

class HitRegion {
 public:
  /// `margin` (m): the cells end at this distance from the region, or a little farther. So no cut lies in the surface of a fragment
  /// that was cut out for the region, and no site's rounding leads into the region. `seen`: the solid through the map of the hit's cells.
  /// This map has a single frame.
  HitRegion(const Region& region, double margin, const SeenSolid& seen);

  /// Whether a point of the region may be within `radius` of `center` (both in the image).
  bool reaches(const Vec3d& center, double radius) const { return space_.depth(center) > -radius; }
  /// Removes the sites inside. The others keep their order.
  void leave_out_inside(std::vector<Vec3d>& sites) const;
  /// `site` is outside. Finer than the site lattice.
  Vec3d companion(const Vec3d& site) const;

 private:
  KeptSpace space_;
  double step_;  ///< m, of the site lattice
};

}  // namespace fracture
