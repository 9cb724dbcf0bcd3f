// Compares winding numbers of many layers, computed together, with those of each part computed alone.
#include "common/clip/winding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/support/growth_families.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

struct Wound {
  Solid solid;
  Tetrahedralization tetrahedra;
  SurfaceCuts cuts;
  Winding winding;
};

Wound wind(const Mesh& mesh, const std::vector<Vec3d>& sites, const Box& box) {
  Wound w{*make_solid(std::make_shared<Mesh>(mesh), {}, {}), *tetrahedralize(sites, box, {}), {}, {}};
  canonicalize(w.tetrahedra);
  const VoronoiDiagram diagram(w.tetrahedra, box);
  w.cuts = cut_surface(w.solid, diagram, {});
  w.winding = wind_voronoi_edges(w.solid, diagram, w.cuts, {});
  return w;
}

/// Segments as (lo, hi, multiplicity) with a description of their ends: tetrahedra, or a triangle and sites.
using End = std::tuple<std::uint32_t, std::array<SiteId, 3>, TetId>;
std::map<std::tuple<SiteId, SiteId, int, End, End>, int> segments_of(const Wound& w, std::uint32_t part,
                                                                     std::uint32_t first_triangle) {
  const auto end = [&](CutVertexId v) -> End {
    if (v >= w.cuts.first_d()) return {0, {}, w.winding.inner_vertices[v - w.cuts.first_d()].tet};
    const TriangleCut& c = w.cuts.triangle_cuts[v - w.cuts.first_c()];
    return {1 + c.triangle - first_triangle, c.sites, TetId{0}};
  };
  std::map<std::tuple<SiteId, SiteId, int, End, End>, int> all;
  for (const CapSegment& s : w.winding.segments)
    if (s.part == part) ++all[{s.lo, s.hi, s.multiplicity, end(s.from), end(s.to)}];
  return all;
}

Box box_of(const Mesh& mesh) {
  Box box;
  for (const Vec3f& p : mesh.positions) box.add(to_double(p));
  return box;
}
std::size_t mesh_of(const Box& box, const std::vector<Mesh>& meshes) {
  std::size_t k = 0;
  while (k < meshes.size() && !(box_of(meshes[k]).min == box.min && box_of(meshes[k]).max == box.max)) ++k;
  return k;
}

TEST(Winding, EachOfManyOverlappingPartsIsWoundAsIfItWereAlone) {
  // A row of cubes in which each overlaps the next ones, a ring through them, and a part far from the others.
  std::vector<Mesh> parts;
  for (int k = 0; k < 12; ++k) parts.push_back(translated(cube(2), {0.21 * k, 0.13 * (k % 3), 0.07 * k}));
  parts.push_back(translated(torus(12, 8), {1, 0, 0}));
  parts.push_back(translated(cube(1), {9, 9, 9}));
  const Mesh all = joined(parts);
  const Box box = box_of(all);
  const std::vector<Vec3d> sites = random_sites(box, 300, 4);
  const Wound together = wind(all, sites, box);
  ASSERT_EQ(together.solid.parts.size(), parts.size());
  ASSERT_GT(together.solid.layers, 4u);

  for (std::uint32_t layer = 0, last = 0, k = 0; k < together.winding.inner_vertices.size(); ++k) {
    layer = together.solid.parts[together.winding.inner_vertices[k].part].layer;
    EXPECT_GE(layer, last) << "inner vertices stand by layer";
    last = layer;
  }
  std::size_t segments = 0;
  for (std::uint32_t part = 0; part < parts.size(); ++part) {
    SCOPED_TRACE("part " + std::to_string(part));
    const auto first =
        static_cast<std::uint32_t>(std::find(together.solid.part.begin(), together.solid.part.end(), part) -
                                   together.solid.part.begin());
    const std::size_t mesh = mesh_of(together.solid.parts[part].box, parts);
    ASSERT_LT(mesh, parts.size());
    const Wound alone = wind(parts[mesh], sites, box);
    std::vector<std::pair<TetId, int>> expected, found;
    for (const InnerVertex& v : alone.winding.inner_vertices) expected.emplace_back(v.tet, v.winding);
    for (const InnerVertex& v : together.winding.inner_vertices)
      if (v.part == part) found.emplace_back(v.tet, v.winding);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(segments_of(together, part, first), segments_of(alone, 0, 0));
    segments += alone.winding.segments.size();
  }
  EXPECT_EQ(together.winding.segments.size(), segments);
}

}  // namespace
}  // namespace fracture::test
