// A hit on a kept answer: what new sites change is made again, on the part of the tetrahedralization and the part of
// the surface that it needs.
//
// What a new site changes: its own cell and those of its Delaunay neighbours, no other (Watson 1981). So
//   - the tetrahedra in conflict with new sites are replaced (kept_tetrahedralization.hpp),
//   - the triangles that met a changed cell are cut again, among all cells that they meet,
//   - winding numbers start from the Voronoi vertices that are still there (clip/winding.hpp),
//   - only facets of changed cells are chained and triangulated, only their pieces assembled, measured and given
//     hulls.
// Cells that stay together (aggregates, lumps of bricks) are one cell here: where a hit changes one of them, all are
// made again. A hit never parts them, and its own are together as local_impact.hpp says.
// Rough cuts: those of changed cells are made among the others as these were kept (rough/moving_caps.hpp). Where the
// others would not stay as they were, their cells count as changed, and the hit is made again.
// What is linear in the whole: a few passes over arrays of numbers per site, a pointer for each block of what is
// shared, bits for the mesh's triangles, vertices and edges, and, to place the sites, a look at each triangle's side
// of them. Where triangles are much larger than cells, all cells that one of them meets are looked at.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/hits/kept_answer.hpp"

namespace fracture {

/// Fragment `fragment` of the cell of `site`, or of the cells that stay together of which it is the lowest. In the order of
/// the answer.
struct PlaceInAnswer {
  SiteId site;
  std::uint32_t fragment;
  auto operator<=>(const PlaceInAnswer&) const = default;
};

struct HitOutcome {
  LocalBase next;                        ///< the answer after the hit
  Delta delta{};                         ///< without neighbours
  std::vector<PlaceInAnswer> changed{};  ///< what the delta says is new or changed, ascending
  std::vector<SiteId> around{};          ///< cells where all bonds of these are kept, ascending
};

/// Inserts the points, images under the map of cells; cells of points with equal groups (none: each for itself) stay
/// together. Nothing where a piece would have to be united or dropped,
/// caps cross, two fragments would get the same id, a site lies outside of the box, or there are too many, and where rough
/// cuts change others farther and farther away: then the whole has to be fractured again. Throws Interrupted.
std::optional<HitOutcome> hit_cells(const Solid& solid, const LocalBase& base, std::span<const Vec3d> points,
                                    std::span<const std::uint32_t> groups,
                                    const FractureParameters& parameters, const Execution& execution);

}  // namespace fracture
