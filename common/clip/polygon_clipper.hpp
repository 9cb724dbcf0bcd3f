// One triangle divided among the cells it meets: Sutherland & Hodgman 1974 clipping by bisectors, cell after
// cell, on polygons whose corners are named by the two lines they lie on and never computed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/clip/surface_cuts.hpp"

namespace fracture {

/// Marks a C vertex whose id is still counted from the start of its block.
inline constexpr VertexId kBlockLocalC = 0x80000000u;

/// The polygons and C vertices of a block of triangles, in SurfaceCuts' layout.
struct TriangleDivision {
  std::vector<TriangleCut> triangle_cuts;
  std::vector<CutPolygon> polygons;
  std::vector<VertexId> vertices;
  std::vector<PolygonSide> sides;
};

class PolygonClipper {
 public:
  /// `cuts` supplies labels and edge cuts; results are appended to `out`.
  PolygonClipper(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                 TriangleDivision& out)
      : solid_(solid), diagram_(diagram), cuts_(cuts), out_(out) {}

  /// Divides triangle t, whose labels are not all the same.
  void divide(std::uint32_t t);

 private:
  bool divide_between_two(std::uint32_t t);
  void clip_to_cell(SiteId cell);
  int side_of_corner(SiteId cell, const Bisector& bisector, PolygonSide before, PolygonSide after) const;
  VertexId name_corner(SiteId cell, PolygonSide before, PolygonSide after);
  VertexId edge_cut(int k, SiteId i, SiteId j) const;

  const Solid& solid_;
  const VoronoiDiagram& diagram_;
  const SurfaceCuts& cuts_;
  TriangleDivision& out_;

  // The triangle at hand.
  std::uint32_t triangle_ = 0;
  std::array<Vec3d, 3> corner_;
  std::size_t first_c_ = 0;           // its C vertices in out_.triangle_cuts
  std::vector<PolygonSide> polygon_;  // the sides, in order
  std::vector<PolygonSide> clipped_;
  std::vector<int> sign_;
  std::vector<SiteId> cells_;  // met so far: done ones, then ones to do
};

}  // namespace fracture
