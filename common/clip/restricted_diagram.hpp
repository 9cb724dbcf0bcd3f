// A Voronoi diagram restricted to a solid: all results of the clipper, in the order in which its stages
// compute them: surface cuts -> winding numbers -> positions -> caps.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/caps.hpp"
#include "common/clip/positions.hpp"
#include "common/clip/surface_cuts.hpp"
#include "common/clip/winding.hpp"
#include "common/solid/image.hpp"

namespace fracture {

/// Borrows the solid and the diagram.
struct RestrictedDiagram {
  const Solid& solid;  ///< provides the positions
  const Solid& seen;   ///< decides the cuts: the solid's image under the diagram's map, or the solid itself
  const VoronoiDiagram& diagram;
  SurfaceCuts cuts;
  Winding winding{};
  VertexPositions positions{};
  Caps caps{};
  /// If `solid` is a patch of a larger solid: the number of each part there. Null: numbers are the same.
  const std::vector<std::uint32_t>* part_in_whole = nullptr;
  /// The brick or stone of masonry that a cell belongs to, for all sites or for the first ones; kNoIndex:
  /// none. Empty: no masonry.
  std::span<const std::uint32_t> bricks{};

  std::uint32_t brick_of(SiteId s) const { return s < bricks.size() ? bricks[s] : kNoIndex; }
  /// Whether the cut between two cells is a joint between two bricks, and not a cut through a brick.
  bool is_joint(const CapRegion& cut) const {
    const std::uint32_t a = brick_of(cut.lo), b = brick_of(cut.hi);
    return a != b && a != kNoIndex && b != kNoIndex;
  }

  /// The corners of a triangle of the solid.
  std::array<CutVertexId, 3> corners(std::uint32_t triangle) const {
    const auto& v = solid.triangles[triangle];
    return {cut_vertex(v[0]), cut_vertex(v[1]), cut_vertex(v[2])};
  }
  /// Unrounded position of any vertex.
  Vec3d point(CutVertexId v) const {
    return v < positions.first_constructed ? to_double(solid.positions[v])
                                           : positions.points[v - positions.first_constructed];
  }
  std::uint32_t vertex_count() const {
    return positions.first_constructed + static_cast<std::uint32_t>(positions.points.size());
  }
  /// Computes positions and caps from the cuts and winding numbers, without roughness, replacing previous
  /// ones. `cells_of_interest`: per site; only facets of these cells get caps; null: all. Throws Interrupted.
  void place_and_cap(const Execution& execution, const std::vector<char>* cells_of_interest = nullptr);
};

/// Runs all stages. `solid` must be seen through diagram.map(). Throws Interrupted.
RestrictedDiagram restrict_to_solid(const SeenSolid& solid, const VoronoiDiagram& diagram,
                                    const Execution& execution);

}  // namespace fracture
