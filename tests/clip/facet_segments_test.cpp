// Compares segments by facet with the definition of their order: for cells with few neighbours, cells with
// many, and cells that several parts share.
#include "common/clip/facet_segments.hpp"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "common/delaunay/tetrahedralization.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

using Facet = std::tuple<SiteId, SiteId, std::uint32_t>;  // (lo, hi, part)
using Segment = std::tuple<CutVertexId, CutVertexId, std::int32_t>;

Facet facet_of(const CapSegment& s) { return {s.lo, s.hi, s.part}; }
Segment segment_of(const CapSegment& s) { return {s.from, s.to, s.multiplicity}; }

/// One site in the middle and `around` sites on a sphere around it. The middle cell has a facet for each of
/// them.
std::vector<Vec3d> hub(int around) {
  std::vector<Vec3d> sites{{0.01, 0.02, 0.03}};
  const Mesh sphere = sphere_with(3 * around, 0.5);
  for (int k = 0; k < around; ++k) sites.push_back(to_double(sphere.positions[static_cast<std::size_t>(k)]));
  return sites;
}

std::size_t most_neighbors(const VoronoiDiagram& diagram) {
  std::size_t most = 0;
  for (std::uint32_t s = 0; s < diagram.dual().site_count(); ++s)
    most = std::max(most, diagram.bisectors(SiteId{s}).size());
  return most;
}

/// The sides of polygons that lie on a bisector, taken from the polygons of the cell with the lower number,
/// in their order. The cap of that cell runs the other way.
std::map<Facet, std::vector<Segment>> segments_of_surface(const Solid& solid, const SurfaceCuts& cuts) {
  std::map<Facet, std::vector<Segment>> segments;
  for (const CutPolygon& p : cuts.polygons)
    for (std::uint32_t k = 0; k < p.count; ++k) {
      const PolygonSide side = cuts.sides[p.first + k];
      if (is_mesh_edge(side) || side < p.cell) continue;
      const CutVertexId from = cuts.vertices[p.first + k], to = cuts.vertices[p.first + (k + 1) % p.count];
      segments[{p.cell, SiteId{side}, solid.part[p.triangle]}].emplace_back(to, from, 1);
    }
  return segments;
}

struct Case {
  const char* name;
  Mesh mesh;
  std::vector<Vec3d> sites;
  std::size_t least_neighbors;  // neighbours of the cell that has the most
};

std::vector<Case> cases() {
  Box box;
  for (const Vec3d& corner : {Vec3d{-1, -1, -1}, Vec3d{1, 1, 1}}) box.add(corner);
  return {{"few neighbours", sphere_with(800), random_sites(box, 150, 3), 10},
          {"more than 64", sphere_with(800), hub(120), 65},
          {"two parts in one cell", joined({sphere_with(300), translated(sphere_with(300), {0.4, 0.3, 0.2})}),
           random_sites(box, 60, 5), 10}};
}

TEST(FacetSegments, StandByFacetSurfaceFirstThenTheWindingInItsOrder) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const Solid solid = *make_solid(std::make_shared<Mesh>(c.mesh), {}, {});
    Box box;
    for (const Vec3f& p : c.mesh.positions) box.add(to_double(p));
    Tetrahedralization tetrahedra = *tetrahedralize(c.sites, box, {});
    canonicalize(tetrahedra);
    const VoronoiDiagram diagram(tetrahedra, box);
    ASSERT_GE(most_neighbors(diagram), c.least_neighbors);
    const SurfaceCuts cuts = cut_surface(solid, diagram, {});
    const Winding winding = wind_voronoi_edges(solid, diagram, cuts, {});
    const FacetSegments found = gather_segments(solid, diagram, cuts, winding, {}, nullptr);

    ASSERT_GE(found.begin.size(), 2u);
    EXPECT_EQ(found.begin.front(), 0u);
    EXPECT_EQ(found.begin.back(), found.all.size());
    std::map<Facet, std::vector<Segment>> expected = segments_of_surface(solid, cuts);
    for (const CapSegment& s : winding.segments) expected[facet_of(s)].push_back(segment_of(s));
    EXPECT_EQ(found.begin.size(), expected.size() + 1);
    for (std::size_t f = 0; f + 1 < found.begin.size(); ++f) {
      const std::size_t begin = found.begin[f], end = found.begin[f + 1];
      ASSERT_LT(begin, end);
      const Facet facet = facet_of(found.all[begin]);
      if (f > 0) {
        ASSERT_LT(facet_of(found.all[begin - 1]), facet);
      }
      std::vector<Segment> here;
      for (std::size_t k = begin; k < end; ++k) {
        ASSERT_EQ(facet_of(found.all[k]), facet);
        here.push_back(segment_of(found.all[k]));
      }
      EXPECT_EQ(here, expected[facet]);
    }
  }
}

}  // namespace
}  // namespace fracture::test
