// Divides a triangle among the cells that it meets. Polygons are clipped by bisectors (Sutherland & Hodgman
// 1974), cell after cell. Their corners are named by the two lines that they are on, and all decisions are
// exact. Near-linear in the polygons and their corners, for any number of corners and of neighbours of a
// cell.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/clip/surface_cuts.hpp"
#include "common/clip/triangle_filter.hpp"
#include "common/clip/triple_table.hpp"

namespace fracture {

/// Marks a C vertex whose id is still relative to the start of its block.
inline constexpr std::uint32_t kBlockLocalC = 0x80000000u;

/// The polygons and C vertices of a block of triangles, in the layout of SurfaceCuts.
struct TriangleDivision {
  std::vector<TriangleCut> triangle_cuts;
  std::vector<CutPolygon> polygons;
  std::vector<CutVertexId> vertices;
  std::vector<PolygonSide> sides;
};

class PolygonClipper {
 public:
  /// `cuts` supplies labels and edge cuts; results are appended to `out`.
  PolygonClipper(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                 const Execution& execution, TriangleDivision& out)
      : solid_(solid), diagram_(diagram), cuts_(cuts), execution_(execution), pacer_(execution), out_(out) {}

  /// Divides triangle t, whose labels must not all be the same. Throws Interrupted.
  void divide(std::uint32_t t);
  /// Reports the polygons made since the last call. divide() reports many at a time.
  void count_polygons();

 private:
  // A corner of the current polygon, and the side after it.
  struct Side {
    PolygonSide side;
    clip_detail::Line line;
    clip_detail::Corner corner;  // between the previous side and this one
    bool corner_is_known;        // otherwise it is not computed yet
    // Only for clip_by_search(): the neighbouring sides, and the index of its bisector.
    std::uint32_t before, after, facet;
  };

  bool divide_between_two(std::uint32_t t);
  void start_polygon();
  void clip_to_cell(SiteId cell);
  void clip_by_all(SiteId cell);
  bool leaves_all(const clip_detail::Line& line);
  void clip_by_search(SiteId cell);
  const Bisector* find_violated(SiteId cell, std::uint32_t corner);
  const Bisector* find_violated_by_tree(SiteId cell, const Side& before, const Side& at);
  bool cut_around(SiteId cell, const Bisector& bisector, std::uint32_t corner);
  clip_detail::Line line_of(SiteId cell, const Bisector& bisector) const;
  int side_of_corner(SiteId cell, const Bisector& bisector, const clip_detail::Line& line, const Side& before,
                     Side& after) const;
  int side_exactly(SiteId cell, const Bisector& bisector, PolygonSide before, PolygonSide after) const;
  void name_polygon(SiteId cell);
  void number_cuts_by_sites(std::size_t first_vertex);
  CutVertexId name_corner(SiteId cell, PolygonSide before, PolygonSide after);
  CutVertexId edge_cut(int k, SiteId i, SiteId j) const;
  void meet_cell(SiteId cell);

  const Solid& solid_;
  const VoronoiDiagram& diagram_;
  const SurfaceCuts& cuts_;
  const Execution& execution_;
  Pacer pacer_;
  TriangleDivision& out_;
  std::size_t counted_ = 0;  // number of polygons already reported

  // The current triangle.
  std::uint32_t triangle_ = 0;
  std::array<Vec3d, 3> corner_;
  std::size_t first_c_ = 0;    // first of its C vertices in out_.triangle_cuts
  std::vector<Side> polygon_;  // the sides, in order
  std::vector<Side> clipped_;
  std::vector<std::uint32_t> unproven_;  // corners that may be beyond a bisector
  std::vector<const Bisector*> doubts_;
  std::vector<int> sign_;
  std::vector<SiteId> cells_;  // cells met so far: first those processed, then the others
  SiteId ray_cell_ = kNoSite;  // where the last ray left a cell with many neighbours; a guess for the next
  std::uint32_t ray_ = 0;
  std::vector<TriangleCut> cuts_before_;
  std::vector<std::uint32_t> number_now_;
  TripleTable names_;  // C vertices, cuts of an edge and cells met, if there are many
};

}  // namespace fracture
