// Finds the pieces of Voronoi edges inside the solid. The C vertices on a Voronoi edge, in order, divide it
// into intervals. The winding number w of the surface increases by one where the edge enters and decreases by
// one where it leaves. The edges form a connected graph, and w = 0 at Voronoi vertices outside the box. So
// one traversal of the tetrahedra gives w everywhere, without any point query. Every cycle must return to the
// same w. If not, the surface was not closed, which is an internal error with ids (the exact test of
// invariant I1).
//
// Each layer (solid.hpp) has its own winding number: a Voronoi vertex inside two overlapping parts is two D
// vertices. One traversal finds all of them. Its cost depends on the tetrahedra, the crossings and what is
// inside, not on the number of layers.
#pragma once

#include <cstdint>
#include <vector>

#include "common/clip/surface_cuts.hpp"

namespace fracture {

/// A directed piece of the boundary of the region solid ∩ facet(lo, hi), lo < hi. It is counter-clockwise
/// seen from hi, that is, for the cap of cell lo, whose normal points from lo to hi. Represents
/// |multiplicity| copies, reversed if < 0.
struct CapSegment {
  SiteId lo, hi;
  CutVertexId from, to;
  std::int32_t multiplicity;
  std::uint32_t part;  ///< index of the solid's part
};

/// A Voronoi vertex inside the solid.
struct InnerVertex {
  TetId tet;
  std::uint32_t part;
  std::int32_t winding;  ///< != 0
};

struct Winding {
  /// The D vertices, with ids from SurfaceCuts::first_d(), by layer, then by tetrahedron.
  std::vector<InnerVertex> inner_vertices;
  std::vector<CapSegment> segments;  ///< pieces of Voronoi edges inside, one for each of three facets
};

Winding wind_voronoi_edges(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                           const Execution& execution);

/// Some cells of a diagram, and the known winding numbers around them.
struct KnownWinding {
  const std::vector<char>& wanted;  ///< per site
  /// Voronoi vertices whose winding numbers are all known ...
  const std::vector<TetId>& known;
  /// ... and those that are not 0; `tet` is an index into `known`.
  const std::vector<InnerVertex>& inner_vertices;
};
/// The same for the wanted cells only. Their inner vertices and the segments of their facets are equal to
/// those of the function above, in the same order. Starts from the known vertices, and from those outside the
/// box.
Winding wind_voronoi_edges_of(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                              const KnownWinding& known, const Execution& execution);

}  // namespace fracture
