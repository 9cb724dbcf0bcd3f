// A barycentric cell that is cut from a patch of the solid equals the cell cut from the whole solid.
#include "common/pipeline/barycentric.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "common/clip/restricted_diagram.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/pipeline/cell_patch.hpp"
#include "common/sites/sites.hpp"
#include "common/voronoi/barycentric_cell.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

Tetrahedralization tetrahedra_of(const std::vector<Vec3d>& sites, const Box& box) {
  Expected<Tetrahedralization> t = tetrahedralize(sites, box, {});
  if (!t) throw std::runtime_error(t.error().detail);
  return std::move(*t);
}

/// Cuts every cell from the whole solid, as the description of fracture_barycentric() says.
std::vector<Fragment> cut_from_the_whole(const Solid& solid, const VoronoiDiagram& diagram) {
  std::vector<Fragment> all;
  for (const SiteId i : ids<SiteId>(diagram.dual().site_count())) {
    const auto mirrored = barycentric_cell(diagram, i);
    if (!mirrored) continue;
    const Tetrahedralization t = tetrahedra_of(*mirrored, solid.box);
    if (t.site_of_input[0] == kNoSite) continue;
    const VoronoiDiagram cell(t, solid.box);
    const RestrictedDiagram restricted = restrict_to_solid(SeenSolid(solid), cell, {});
    Ownership ownership = Ownership::from_groups(t.site_count(), {});
    ownership.wanted.assign(t.site_count(), false);
    ownership.wanted[t.site_of_input[0]] = true;
    for (Fragment& f : make_fragments(restricted, ownership, Pivot::kCenterOfMass, {}, {}).fragments) {
      f.sites = {i};
      all.push_back(std::move(f));
    }
  }
  return all;
}

void expect_same(const std::vector<Fragment>& found, const std::vector<Fragment>& expected,
                 const std::string& what) {
  ASSERT_EQ(found.size(), expected.size()) << what;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Fragment &a = found[k], &b = expected[k];
    EXPECT_EQ(a.id, b.id) << what << " " << k;
    EXPECT_EQ(a.sites, b.sites);
    EXPECT_EQ(a.part, b.part);
    EXPECT_EQ(a.pivot, b.pivot);
    EXPECT_EQ(a.positions, b.positions) << what << " " << k;
    EXPECT_EQ(a.indices, b.indices);
    EXPECT_EQ(a.topology, b.topology);
    EXPECT_EQ(a.attributes.normals, b.attributes.normals);
    EXPECT_EQ(a.attributes.uvs, b.attributes.uvs);
    EXPECT_EQ(a.mass.volume, b.mass.volume);
    EXPECT_EQ(a.mass.inertia, b.mass.inertia);
  }
}

TEST(Barycentric, SaysByNameWhichLimitsOfSizeItDoesNotKnow) {
  FractureParameters p;
  p.sites = 20;
  p.dual = Dual::kBarycenter;
  const Report plain = fracture_mesh(cube(), p).report;
  EXPECT_TRUE(plain.remarks.warnings.empty()) << "that they overlap was asked for";
  EXPECT_TRUE(has_note(plain, "the fragments overlap and leave gaps"));
  using Sentences = std::vector<std::string>;
  const auto only = [](const std::string& names) -> Sentences {
    return {"dual=barycenter: fragments are not merged by size, because they share no cuts, so " + names +
            " had no effect. Leave out either the size limits or 'dual'."};
  };
  p.size.min_volume = 1e-3;
  p.size.min_of_mean = 0.002;  // may be of a material, so another room names it
  EXPECT_EQ(fracture_mesh(cube(), p).report.remarks.warnings, only("'min_volume'"));
  p.size = {.min_fraction = 0.01};
  EXPECT_EQ(fracture_mesh(cube(), p).report.remarks.warnings, only("'min_fraction'"));
  p.size = {.fragments = 5, .max_fragments = 7, .max_triangles = 100};
  EXPECT_EQ(fracture_mesh(cube(), p).report.remarks.warnings,
            only("'fragments', 'max_fragments', 'max_triangles'"));
  p.max_volume = 0.02;
  const Sentences two = fracture_mesh(cube(), p).report.remarks.warnings;
  ASSERT_EQ(two.size(), 2u);
  EXPECT_NE(two[0].find("because this limit divides Voronoi cells, but the hulls of dual=barycenter can be "
                        "larger. Use a smaller 'max_volume'"),
            std::string::npos)
      << two[0];
  EXPECT_EQ(two[1], only("'fragments', 'max_fragments', 'max_triangles'")[0]);
}

TEST(Barycentric, HitsOnWholePartsMakeVoronoiCells) {
  FractureParameters p;
  p.sites = 20;
  p.hits = {{{0.5, 0, 0}, 0.3, 8}};
  const Fractured exact = fracture_mesh(cube(), p);
  p.dual = Dual::kBarycenter;
  const Fractured same = fracture_mesh(cube(), p);
  EXPECT_EQ(same.report.remarks, exact.report.remarks);
  EXPECT_FALSE(same.report.barycenter);
  EXPECT_EQ(same.set.bonds.size(), exact.set.bonds.size());
  expect_same(same.set.fragments, exact.set.fragments, "local_rest=whole");
}

TEST(Barycentric, HitsMergeTheirPiecesBySize) {
  FractureParameters p;
  p.sites = 20;
  p.dual = Dual::kBarycenter;
  p.hits = {{{0.5, 0, 0}, 0.3, 8}};
  p.rest = LocalRest::kFractured;
  p.size.min_volume = 1e-6;
  const Fractured made = fracture_mesh(cube(), p);
  EXPECT_FALSE(warns(made.report, "had no effect"));
  EXPECT_TRUE(has_note(made.report, "the fragments overlap and leave gaps"));
  EXPECT_FALSE(has_note(made.report, "each cell is a separate fragment")) << "the pattern has no groups";
  double before = 0;
  p.hits.clear();
  for (const Fragment& f : fracture_mesh(cube(), p).set.fragments) before += f.mass.volume;
  EXPECT_NEAR(made.set.weighed_volume, before, 1e-9);
}

TEST(Barycentric, APatchOfTheSolidGivesTheFragmentsOfTheWhole) {
  std::vector<NamedMesh> shapes = closed_shapes();
  shapes.push_back({"nested spheres", nested_spheres(5, 400)});
  shapes.push_back({"cube field", cube_field(3)});
  shapes.push_back({"self-crossing tube", self_crossing_tube()});
  shapes.push_back({"seams", cube_with_seams()});
  // Overlapping parts: the winding number at a point comes from several surfaces.
  shapes.push_back({"overlapping",
                    joined({cube(), translated(cube(2), {0.25, 0.1, 0.3}), scaled(cube(3), {0.5, 2, 0.5})})});
  for (const NamedMesh& shape : shapes) {
    const Solid solid = solid_of(shape.mesh);
    for (const std::uint32_t count : {1u, 9u, 40u}) {
      const Tetrahedralization t = tetrahedra_of(*uniform_sites(solid, count, 7, {}), solid.box);
      const VoronoiDiagram diagram(t, solid.box);
      expect_same(fracture_barycentric(solid, diagram, Pivot::kCenterOfMass, 0, {}).set.fragments,
                  cut_from_the_whole(solid, diagram), shape.name + " " + std::to_string(count));
    }
  }
}

// The sites are on the lattice of the mesh's own vertices. So planes of hulls pass through its faces, edges
// and vertices, and Voronoi vertices are on its surface. Only the tie rule decides on which side they are.
TEST(Barycentric, APatchGivesTheFragmentsOfTheWholeWhereEverythingTouches) {
  for (const Mesh& mesh : {cube(4), cube_field(2), menger_sponge(1), nested_spheres(3, 200, 0.25)}) {
    const Solid solid = solid_of(mesh);
    std::vector<Vec3d> sites;
    const Vec3d size = solid.box.size();
    for (int x = 0; x < 4; ++x)
      for (int y = 0; y < 4; ++y)
        for (int z = 0; z < 4; ++z)
          sites.push_back(solid.box.min + Vec3d{size.x * x / 4, size.y * y / 4, size.z * z / 4} +
                          0.125 * size);
    const Tetrahedralization t = tetrahedra_of(sites, solid.box);
    const VoronoiDiagram diagram(t, solid.box);
    expect_same(fracture_barycentric(solid, diagram, Pivot::kCenterOfMass, 0, {}).set.fragments,
                cut_from_the_whole(solid, diagram), std::to_string(mesh.triangles.size()));
  }
}

// Formerly the cost was sites x triangles: with four times as many of both, it was sixteen times as high.
TEST(Barycentric, LooksAtEachTriangleAFewTimesHoweverManyCellsThereAre) {
  std::vector<double> a_triangle_or_cell;
  for (const std::uint32_t size : {1u, 4u, 16u}) {
    const Solid solid = solid_of(sphere_with(static_cast<int>(1000 * size)));
    const std::uint32_t count = 50 * size;
    const Tetrahedralization t = tetrahedra_of(*uniform_sites(solid, count, 3, {}), solid.box);
    const VoronoiDiagram diagram(t, solid.box);
    const BarycentricResult result = fracture_barycentric(solid, diagram, Pivot::kCenterOfMass, 0, {});
    std::uint64_t made = 0;
    for (const Fragment& f : result.set.fragments) made += f.indices.size() / 3;
    a_triangle_or_cell.push_back(static_cast<double>(result.looked_at) /
                                 static_cast<double>(solid.triangles.size() + made));
  }
  EXPECT_LT(a_triangle_or_cell[0], 4);
  for (std::size_t k = 1; k < a_triangle_or_cell.size(); ++k)
    EXPECT_LT(a_triangle_or_cell[k], 1.3 * a_triangle_or_cell[k - 1]) << k;
}

TEST(Barycentric, CanBeInterruptedAnywhere) {
  const Solid solid = solid_of(sphere_with(100'000));
  // One cell has thousands of neighbours, so its hull is the largest.
  std::vector<Vec3d> sites = *uniform_sites(solid, 100, 5, {});
  for (const Vec3f& p : sphere_with(3000, 0.5).positions) sites.push_back(to_double(p));
  sites.push_back({0, 0, 0});
  const Tetrahedralization t = tetrahedra_of(sites, solid.box);
  const VoronoiDiagram diagram(t, solid.box);
  const Polled made = polled([&](const Execution& execution) {
    EXPECT_GT(fracture_barycentric(solid, diagram, Pivot::kCenterOfMass, 0, execution).set.fragments.size(),
              100u);
  });
  EXPECT_LT(made.longest_ms, kMostPollGapMs);
}

}  // namespace
}  // namespace fracture::test
