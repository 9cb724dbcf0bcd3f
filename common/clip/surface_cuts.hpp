// The restricted Voronoi diagram of the surface. Every mesh triangle is divided among the cells that it
// meets, with symbolic vertices (Yan et al. 2009, "Isotropic remeshing with fast and exact computation of
// restricted Voronoi diagram"; Lévy 2016 for the symbolic vertices). There are three passes. Each is
// near-linear and decides exactly:
//   labels      the cell of each mesh vertex, by a greedy walk from a neighbour's label
//   edge cuts   points where a mesh edge goes from cell to cell (B vertices)
//   polygons    triangle ∩ cell for every cell that meets a triangle whose labels differ (C vertices)
// A cell is convex, so a triangle whose labels agree is in one cell and needs no cutting.
//
// Vertex names (keys), one space of CutVertexId for the whole solid:
//   A  mesh vertex v                                   ids [0, vertices)
//   B  mesh edge e x bisector(i, j)                    ids [vertices, vertices + edge_cuts)
//   C  mesh triangle t x Voronoi edge (i, j, k)        ids [.. , .. + triangle_cuts)
//   D  Voronoi vertex (tetrahedron) in a layer         ids from there on (winding.hpp)
// Both sides of every cut use the same ids, so no gap can open.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

using CutVertexId = Id<struct CutVertexTag>;
/// The id of an A vertex.
constexpr CutVertexId cut_vertex(VertexId mesh_vertex) { return CutVertexId{std::uint32_t{mesh_vertex}}; }

/// A point at which an edge, followed from its lower to its higher vertex id, leaves cell `from` and enters
/// cell `to`.
struct EdgeCut {
  std::uint32_t edge;
  SiteId from, to;
};

struct TriangleCut {
  std::uint32_t triangle;
  std::array<SiteId, 3> sites;  ///< ascending
};

/// The line that contains a side of a polygon: a neighbour's site id (for the bisector of `cell` and the
/// neighbour), or kMeshEdge + k for the triangle's edge from corner k to corner k+1.
using PolygonSide = std::uint32_t;
inline constexpr PolygonSide kMeshEdge = 0xfffffff0u;
inline bool is_mesh_edge(PolygonSide side) { return side >= kMeshEdge; }

/// triangle ∩ cell: a convex polygon, counter-clockwise like the triangle. Side k goes from vertex k to
/// vertex k+1. Side 0 is on the bisector of the neighbour with the lowest id.
struct CutPolygon {
  std::uint32_t triangle;
  SiteId cell;
  std::uint32_t first, count;  ///< range of SurfaceCuts::vertices and ::sides
};

struct SurfaceCuts {
  std::vector<SiteId> label;                  ///< per mesh vertex
  std::vector<std::uint32_t> edge_cut_begin;  ///< per mesh edge + 1: its range of edge_cuts
  std::vector<EdgeCut> edge_cuts;             ///< B vertices, by edge, in order along the edge
  std::vector<TriangleCut> triangle_cuts;     ///< C vertices, by triangle
  std::vector<CutPolygon> polygons;           ///< only of cut triangles, by triangle, then ascending by cell
  std::vector<CutVertexId> vertices;
  std::vector<PolygonSide> sides;

  CutVertexId first_b() const { return CutVertexId{label.size()}; }
  CutVertexId first_c() const { return CutVertexId{first_b() + edge_cuts.size()}; }
  CutVertexId first_d() const { return CutVertexId{first_c() + triangle_cuts.size()}; }
};

SurfaceCuts cut_surface(const Solid& solid, const VoronoiDiagram& diagram, const Execution& execution);

/// The same, if the cell of each mesh vertex is already known.
SurfaceCuts cut_surface(const Solid& solid, const VoronoiDiagram& diagram, std::vector<SiteId> label,
                        const Execution& execution);

}  // namespace fracture
