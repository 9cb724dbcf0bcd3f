// A region of space that never breaks: every cell that meets it belongs to one group, so that no cut runs
// through it.
#pragma once

#include <span>
#include <vector>

#include "common/rough/displacement.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

struct Region {
  enum class Shape { kSphere, kBox };
  Shape shape = Shape::kSphere;
  Vec3d center{};     ///< of a sphere
  double radius = 0;  ///< of a sphere, m
  Box box{};          ///< of a box
};

/// The sites whose cells meet the region within `bounds` (the diagram's box), ascending; none where the
/// region lies outside. Judged in doubles with a margin of 1e-9 of the box: a cell that only almost meets the
/// region may be among them, one that meets it is never missing. Walks over the facets that meet the region,
/// from the cell of one of its points: a convex region is not divided by the cells it does not meet. Linear
/// in the tetrahedra around the cells that meet it. `movements`: of the cuts, one for each frame of the diagram's map
/// (one without a map); also the cells whose cuts may come into the region by that are found. Empty: cuts stay flat.
/// Throws Interrupted.
std::vector<SiteId> cells_meeting(const Region& region, const VoronoiDiagram& diagram, const Box& bounds,
                                  const Execution& execution = {}, std::span<const Movement> movements = {});

}  // namespace fracture
