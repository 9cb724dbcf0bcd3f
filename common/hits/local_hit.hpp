// A hit on a stored answer. Makes again only what new sites change, on the necessary part of the
// tetrahedralization and of the surface.
//
// A new site changes its own cell and the cells of its Delaunay neighbours, and no others (Watson 1981). So
//   - the tetrahedra in conflict with new sites are replaced (kept_tetrahedralization.hpp),
//   - the triangles that met a changed cell are cut again, among all cells that they meet,
//   - winding numbers start from the Voronoi vertices that still exist (clip/winding.hpp),
//   - only facets of changed cells are chained and triangulated, and only their pieces are assembled,
//     measured and given hulls.
// Cells that stay together (aggregates, lumps of bricks) count as one cell here: if a hit changes one of
// them, all are made again. A hit never separates them. local_impact.hpp explains which of its own cells stay
// together.
// Rough cuts of changed cells are made among the stored cuts of the other cells (rough/moving_caps.hpp). If
// the others would change too, their cells count as changed, and the hit is made again.
// The following is linear in the whole: a few passes over arrays with numbers per site, a pointer per block
// of shared data, bits for the mesh's triangles, vertices and edges, and, to place the sites, one test per
// triangle. If triangles are much larger than cells, all cells that one of them meets are processed.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/hits/kept_answer.hpp"

namespace fracture {

/// Fragment `fragment` of the cell of `site`, or of the cells that stay together and whose lowest it is.
/// Sorted in the order of the answer.
struct PlaceInAnswer {
  SiteId site;
  std::uint32_t fragment;
  auto operator<=>(const PlaceInAnswer&) const = default;
};

struct HitOutcome {
  LocalBase next;                        ///< the answer after the hit
  Delta delta{};                         ///< without neighbours
  std::vector<PlaceInAnswer> changed{};  ///< the fragments that are new or changed in the delta, ascending
  std::vector<SiteId> around{};          ///< the cells that store all bonds of these fragments, ascending
};

/// Inserts the points, which are images under the map of cells. Cells of points with equal groups stay
/// together (without groups, each is alone). Throws Interrupted.
///
/// Returns nothing if the whole must be fractured again. This happens if a piece would have to be united or
/// dropped, caps cross, two fragments would get the same id, a site is outside the box, or there are too many
/// sites. It also happens if rough cuts change others farther and farther away.
std::optional<HitOutcome> hit_cells(const Solid& solid, const LocalBase& base, std::span<const Vec3d> points,
                                    std::span<const std::uint32_t> groups,
                                    const FractureParameters& parameters, const Execution& execution);

}  // namespace fracture
