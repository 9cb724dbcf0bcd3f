// A region of space that never breaks, and the cells that meet it (see also kept_space.hpp, keep_sites.hpp).
#pragma once

#include <span>
#include <vector>

#include "common/rough/displacement.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

struct Region {
  enum class Shape { kSphere, kBox };
  Shape shape = Shape::kSphere;
  Vec3d center{};     ///< for a sphere
  double radius = 0;  ///< for a sphere, m
  Box box{};          ///< for a box
};

inline Box box_of(const Region& region) {
  if (region.shape == Region::Shape::kBox) return region.box;
  const Vec3d r{region.radius, region.radius, region.radius};
  return {region.center - r, region.center + r};
}

/// Returns the sites whose cells meet the region within `bounds` (the diagram's box), ascending; none if
/// the region lies outside. Uses doubles with a margin of 1e-9 of the box: a cell that almost meets the
/// region may be included, but one that meets it is never missing. Starts from the cell of a point in the
/// region and walks across the facets that meet the region. This finds all cells, because a region is
/// convex. Linear in the tetrahedra around the cells found. `movements`: of the cuts, one for each frame of
/// the diagram's map (one without a map). With them, cells whose moved cuts may enter the region are found,
/// too. Empty: cuts stay flat. Throws Interrupted.
std::vector<SiteId> cells_meeting(const Region& region, const VoronoiDiagram& diagram, const Box& bounds,
                                  const Execution& execution = {}, std::span<const Movement> movements = {});

}  // namespace fracture
