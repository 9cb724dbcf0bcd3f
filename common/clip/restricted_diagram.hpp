// A Voronoi diagram restricted to a solid: everything that the clipper finds, in the order in which its
// stages find it: surface cuts -> winding numbers -> positions -> caps.
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
  const Solid& solid;  ///< has the positions
  const Solid& seen;   ///< decides: the solid's image under the diagram's map, or the solid itself
  const VoronoiDiagram& diagram;
  SurfaceCuts cuts;
  Winding winding{};
  VertexPositions positions{};
  Caps caps{};
  /// Where `solid` is a patch of a larger one: per part its number there; null: the number it has here.
  const std::vector<std::uint32_t>* part_in_whole = nullptr;
  /// Per site, or of the first ones: the brick or stone of a masonry that its cell is of; kNoIndex: of none. Empty: of
  /// none.
  std::span<const std::uint32_t> bricks{};

  std::uint32_t brick_of(SiteId s) const { return s < bricks.size() ? bricks[s] : kNoIndex; }
  /// Whether the cut between two cells is where two bricks were laid, not through one.
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
  /// Makes positions and caps from the cuts and winding numbers, flat and whole, whatever they were.
  /// `cells_of_interest`: per site; only the facets of these have caps; null: of all. Throws Interrupted.
  void place_and_cap(const Execution& execution, const std::vector<char>* cells_of_interest = nullptr);
};

/// All stages. `solid` must be seen through diagram.map(). Throws Interrupted.
RestrictedDiagram restrict_to_solid(const SeenSolid& solid, const VoronoiDiagram& diagram,
                                    const Execution& execution);

}  // namespace fracture
