// The cutter has several methods. The number of a cell's neighbours or of a triangle's polygons decides which
// one it uses. All methods must give the same answer.
#include "common/clip/surface_cuts.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "common/exact/side.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

void expect_equal(const SurfaceCuts& a, const SurfaceCuts& b) {
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.edge_cut_begin, b.edge_cut_begin);
  ASSERT_EQ(a.edge_cuts.size(), b.edge_cuts.size());
  for (std::size_t k = 0; k < a.edge_cuts.size(); ++k) {
    EXPECT_EQ(a.edge_cuts[k].from, b.edge_cuts[k].from);
    EXPECT_EQ(a.edge_cuts[k].to, b.edge_cuts[k].to);
  }
  ASSERT_EQ(a.triangle_cuts.size(), b.triangle_cuts.size());
  for (std::size_t k = 0; k < a.triangle_cuts.size(); ++k) {
    EXPECT_EQ(a.triangle_cuts[k].triangle, b.triangle_cuts[k].triangle);
    EXPECT_EQ(a.triangle_cuts[k].sites, b.triangle_cuts[k].sites);
  }
  ASSERT_EQ(a.polygons.size(), b.polygons.size());
  for (std::size_t k = 0; k < a.polygons.size(); ++k) {
    EXPECT_EQ(a.polygons[k].triangle, b.polygons[k].triangle);
    EXPECT_EQ(a.polygons[k].cell, b.polygons[k].cell);
  }
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.sides, b.sides);
}

/// Lattice points on a sphere around one site in the middle: ties everywhere.
std::vector<Vec3d> lattice_hub(const Box& box) {
  const Vec3d center = box.center();
  const double step = std::ldexp(box.longest_side(), -6);
  std::vector<Vec3d> sites{center};
  for (int x = -21; x <= 21; ++x)
    for (int y = -21; y <= 21; ++y)
      for (int z = -21; z <= 21; ++z)
        if (x * x + y * y + z * z == 441) sites.push_back(center + step * Vec3d{1.0 * x, 1.0 * y, 1.0 * z});
  return sites;
}

TEST(SurfaceCuts, SearchedAndScannedCellsGiveTheSameCuts) {
  const GrowthFamily* hub = find_growth_family("hub");
  ASSERT_NE(hub, nullptr);
  const GrowthInput grown = hub->make(200, 3);
  std::vector<std::tuple<std::string, Mesh, std::vector<Vec3d>>> cases{{"hub", grown.mesh, grown.sites}};
  for (const NamedMesh& shape : {NamedMesh{"cube", cube(3)}, NamedMesh{"torus", torus(24, 16)},
                                 NamedMesh{"plate", thin_plate(0.01, 2)}}) {
    for (const SiteFamily& family : small_site_families(shape.mesh, 5))
      cases.emplace_back(shape.name + " " + family.name, shape.mesh, family.sites);
    Box box;
    for (const Vec3f& p : shape.mesh.positions) box.add(to_double(p));
    cases.emplace_back(shape.name + " lattice hub", shape.mesh, lattice_hub(box));
  }
  for (const auto& [name, mesh, sites] : cases) {
    SCOPED_TRACE(name);
    const Solid solid = solid_of(mesh);
    const Expected<Tetrahedralization> t = tetrahedralize(sites, solid.box, {});
    ASSERT_TRUE(t);
    const VoronoiDiagram scanned(*t, solid.box, {}, kUninterrupted, 1u << 30);
    const VoronoiDiagram searched(*t, solid.box, {}, kUninterrupted, 0);
    const SurfaceCuts expected = cut_surface(solid, scanned, {});
    expect_equal(cut_surface(solid, searched, {}), expected);
    Execution two;
    two.threads = 2;
    expect_equal(cut_surface(solid, scanned, two), expected);
  }
}

TEST(SurfaceCuts, ATriangleOfManyPolygonsNamesEachCornerOnce) {
  const Solid solid = solid_of(box({0, 0, 0}, {1, 1, 0.01}));
  const Expected<Tetrahedralization> t = tetrahedralize(random_sites(solid.box, 700, 11), solid.box, {});
  ASSERT_TRUE(t);
  const VoronoiDiagram diagram(*t, solid.box);
  const SurfaceCuts cuts = cut_surface(solid, diagram, {});
  std::set<std::pair<std::uint32_t, std::array<SiteId, 3>>> names;
  for (const TriangleCut& c : cuts.triangle_cuts) EXPECT_TRUE(names.insert({c.triangle, c.sites}).second);
  // Within a triangle, each side between two cells occurs once from each cell, between the same corners.
  std::map<std::tuple<std::uint32_t, SiteId, SiteId>, std::pair<CutVertexId, CutVertexId>> sides;
  std::size_t between_cells = 0;
  for (const CutPolygon& p : cuts.polygons)
    for (std::uint32_t k = 0; k < p.count; ++k) {
      const PolygonSide side = cuts.sides[p.first + k];
      if (is_mesh_edge(side)) continue;
      ++between_cells;
      EXPECT_TRUE(sides
                      .insert({{p.triangle, p.cell, SiteId{side}},
                               {cuts.vertices[p.first + k], cuts.vertices[p.first + (k + 1) % p.count]}})
                      .second);
    }
  EXPECT_GT(between_cells, 4000u);
  for (const auto& [key, ends] : sides) {
    const auto& [triangle, cell, side] = key;
    const auto other = sides.find({triangle, side, cell});
    ASSERT_NE(other, sides.end());
    EXPECT_EQ(other->second, std::pair(ends.second, ends.first));
  }
}

}  // namespace
}  // namespace fracture::test
