// Crossings of the surface with the Voronoi edges: C vertices in order along each edge. Private to
// winding.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/surface_cuts.hpp"

namespace fracture::clip_detail {

/// A C vertex on a Voronoi edge with direction (j - i) x (k - i), i < j < k.
struct Crossing {
  std::uint32_t cut;  ///< index into SurfaceCuts::triangle_cuts
  int step;           ///< change of w in that direction: +1 if it enters the solid, -1 if it leaves
};

/// The crossings of one Voronoi edge with one layer, in order.
struct LayerCrossings {
  std::uint32_t layer;
  std::uint32_t first, count;  ///< range of the crossings
  std::int32_t jump;           ///< sum of steps
};

struct CrossedEdge {
  std::uint32_t first, count;  ///< range of its layers, ascending
  TetId tet;                   ///< one of its two end vertices ...
  int face;                    ///< ... and the facet of this tetrahedron that is dual to the edge
  bool forward;                ///< whether the crossings' direction leads out of `tet` through `face`
};

struct CrossingTable {
  std::vector<CrossedEdge> edges;
  std::vector<LayerCrossings> layers;
  std::vector<Crossing> crossings;

  std::span<const LayerCrossings> layers_of(const CrossedEdge& e) const {
    return {layers.data() + e.first, e.count};
  }
};

/// `wanted` (per site; null: all): leaves out Voronoi edges that touch none of these cells. Throws
/// Interrupted.
CrossingTable find_crossings(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                             const std::vector<char>* wanted, const Execution& execution);

}  // namespace fracture::clip_detail
