// Which pieces of Voronoi edges lie inside the solid. The C vertices on a Voronoi edge, put in order along
// it, cut it into intervals; the winding number w of the surface rises by one where the edge enters and falls
// by one where it leaves. The edges form a connected graph, and w = 0 at Voronoi vertices beyond the box, so
// one traversal of the tetrahedra gives w everywhere without a single point query. Every circuit must come
// back to the same w: if not, the surface was not closed, and that is an internal error with ids (invariant
// I1's exact test).
//
// Each layer (solid.hpp) has a winding number of its own: a Voronoi vertex that lies inside two overlapping
// parts is two D vertices. One traversal finds all of them, at the cost of the tetrahedra, the crossings and
// what is inside, however many layers there are.
#pragma once

#include <cstdint>
#include <vector>

#include "common/clip/surface_cuts.hpp"

namespace fracture {

/// A directed piece of the boundary of the region solid ∩ facet(lo, hi), lo < hi: counter-clockwise seen from
/// hi, that is, as the cap of cell lo whose normal points from lo to hi. Stands for |multiplicity| copies,
/// reversed when < 0.
struct CapSegment {
  SiteId lo, hi;
  CutVertexId from, to;
  std::int32_t multiplicity;
  std::uint32_t part;  ///< of the solid
};

/// A Voronoi vertex inside the solid.
struct InnerVertex {
  TetId tet;
  std::uint32_t part;
  std::int32_t winding;  ///< != 0
};

struct Winding {
  /// The D vertices: ids from SurfaceCuts::first_d() on. By layer, then tetrahedron.
  std::vector<InnerVertex> inner_vertices;
  std::vector<CapSegment> segments;  ///< pieces of Voronoi edges inside the solid, each for its three facets
};

Winding wind_voronoi_edges(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                           const Execution& execution);

/// Some cells of a diagram, and what is known of the Voronoi vertices around them.
struct KnownWinding {
  const std::vector<char>& wanted;  ///< per site
  /// Voronoi vertices of which all that winds around them is known ...
  const std::vector<TetId>& known;
  /// ... and that, where it is anything; `tet` is an index into `known`.
  const std::vector<InnerVertex>& inner_vertices;
};
/// The same for the wanted cells alone: their inner vertices and the segments of their facets, equal to those of
/// the function above and in the same order. Starts from the known vertices, and from those beyond the box.
Winding wind_voronoi_edges_of(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                              const KnownWinding& known, const Execution& execution);

}  // namespace fracture
