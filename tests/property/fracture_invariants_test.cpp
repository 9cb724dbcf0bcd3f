// I1, I2, I3 and I7 over every closed shape and mesh, for harmless and adversarial sites. The sites are given
// as points (distinct ids in the caller's order). The names of the cases contain the seeds. In short tests
// each family of sites runs on some of the inputs.
#include <gtest/gtest.h>

#include "common/pipeline/fracture.hpp"
#include "tests/property/judge.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

constexpr std::uint64_t kSeed = 20261121;

FractureParameters at_points(std::vector<Vec3d> points) {
  FractureParameters p;
  p.pattern = PointsPattern{std::move(points)};
  return p;
}

/// `input` is the number of has_turn().
void expect_all_invariants(const Mesh& mesh, const std::vector<SiteFamily>& families, bool embedded,
                           std::size_t input) {
  const Mesh traced = with_traced_triangles(mesh);
  const double volume = volume_of(mesh), area = area_of(mesh);
  for (std::size_t k = 0; k < families.size(); ++k) {
    if (!has_turn(input, k, 3)) continue;
    const SiteFamily& family = families[k];
    SCOPED_TRACE("sites: " + family.name);
    const Fractured f = fracture_mesh(traced, at_points(family.sites));
    expect_closed(f.set);
    expect_partition(f.set, volume, area);
    expect_outside_untouched(f.set, traced);
    EXPECT_EQ(f.set.certificate.open_edges, 0u);
    if (embedded) {
      EXPECT_EQ(f.set.certificate.crossing_caps, 0u);
    }
    EXPECT_EQ(f.set.certificate.dropped, 0u);
    for (const Bond& b : f.set.bonds) {
      EXPECT_GT(b.area, 0);
      EXPECT_LT(b.a, b.b);
      EXPECT_LT(b.b, f.set.fragments.size());
      EXPECT_NEAR(length(b.normal), 1, 1e-12);
    }
  }
}

// ---- generated shapes

class ClosedShape : public OnClosedShape {};

TEST_P(ClosedShape, KeepsAllInvariantsForEverySiteFamily) {
  expect_all_invariants(shape().mesh, site_families(shape().mesh, kSeed), true, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Seed20261121, ClosedShape, every_closed_shape(), name_of_shape);

// ---- real meshes

class ClosedMesh : public OnClosedMesh {};

TEST_P(ClosedMesh, KeepsAllInvariantsForEverySiteFamily) {
  expect_all_invariants(mesh, small_site_families(mesh, kSeed), embedded(), number());
}

INSTANTIATE_TEST_SUITE_P(Dev, ClosedMesh, every_closed_mesh(), name_of_mesh);

// ---- far from the origin

TEST(FractureFarFromOrigin, SeamsStayBitIdenticalAtZeroFourHundredAndThousandSizes) {
  std::size_t input = 0;
  for (const char* shape : {"cube", "uv_sphere", "torus"})
    for (const double distance : {0.0, 4.0, 100.0, 1000.0}) {
      ++input;  // modulo 3, so that each distance has different numbers for the shapes
      std::size_t turn = 0;
      for (const Vec3d& direction : {Vec3d{1, 1, 1}, Vec3d{0, 1, 0}, Vec3d{-1, 0, 0}}) {
        if (!has_turn(input, turn++, 3)) continue;
        SCOPED_TRACE(std::string(shape) + " at " + std::to_string(distance));
        Mesh mesh;
        for (const NamedMesh& s : all_closed_shapes())
          if (s.name == shape) mesh = s.mesh;
        ASSERT_FALSE(mesh.positions.empty());
        mesh = with_traced_triangles(translated(mesh, distance * box_of(mesh).longest_side() * direction));
        const Fractured f = fracture_mesh(mesh, at_points(random_sites(box_of(mesh), 50, kSeed)));
        expect_closed(f.set);
        expect_partition(f.set, volume_of(mesh), area_of(mesh));
        expect_outside_untouched(f.set, mesh);
      }
    }
}

// ---- the fracture is the Voronoi diagram

TEST(FractureIsTheVoronoiDiagram, PointsLieInTheFragmentOfTheirNearestSite) {
  std::size_t input = 0;
  for (const NamedMesh& shape : all_closed_shapes()) {
    ++input;
    if (shape.name == "thin_plate") continue;  // thinner than the point test can resolve
    SCOPED_TRACE(shape.name);
    std::size_t turn = 0;
    for (const SiteFamily& family : small_site_families(shape.mesh, kSeed)) {
      if (!has_turn(input, turn++, 4)) continue;
      SCOPED_TRACE(family.name);
      if (family.name == "cluster") continue;  // so are its cells
      const Fractured f = fracture_mesh(shape.mesh, at_points(family.sites));
      // Fragments name sites of the tetrahedralization (duplicates merged). The brute force uses the same
      // list.
      const std::span<const Vec3d> sites(f.diagram.tetrahedralization.points.data(),
                                         f.diagram.tetrahedralization.site_count());
      expect_voronoi(f.set, shape.mesh, sites, 2000, kSeed);
    }
  }
}

TEST(FractureIsTheVoronoiDiagram, HundredThousandPointsOfATorus) {
  const Mesh mesh = torus(48, 24);
  const Fractured f = fracture_mesh(mesh, at_points(random_sites(box_of(mesh), 200, kSeed)));
  const std::span<const Vec3d> sites(f.diagram.tetrahedralization.points.data(),
                                     f.diagram.tetrahedralization.site_count());
  expect_voronoi(f.set, mesh, sites, sized(10'000, 100'000), kSeed);
}

TEST(FractureCounts, FragmentsAreCellsPlusIslandsLessUnionsAndDrops) {
  std::size_t input = 0;
  for (const NamedMesh& shape : all_closed_shapes()) {
    ++input;
    std::size_t turn = 0;
    for (const SiteFamily& family : small_site_families(shape.mesh, kSeed)) {
      if (!has_turn(input, turn++, 4)) continue;
      SCOPED_TRACE(shape.name + " " + family.name);
      const Certificate c = fracture_mesh(shape.mesh, at_points(family.sites)).set.certificate;
      EXPECT_EQ(c.fragments, c.cells + c.islands - c.united - c.dropped);
    }
  }
}

// ---- groups

TEST(FractureGroups, OneGroupOfAllCellsReturnsTheInputTrianglesBitForBit) {
  for (const NamedMesh& shape : all_closed_shapes()) {
    SCOPED_TRACE(shape.name);
    const Mesh mesh = with_traced_triangles(shape.mesh);
    PointsPattern pattern{random_sites(box_of(mesh), 60, kSeed)};
    pattern.groups.assign(pattern.points.size(), 7);
    FractureParameters p;
    p.pattern = std::move(pattern);
    const Fractured f = fracture_mesh(mesh, p);
    EXPECT_EQ(f.set.bonds.size(), 0u);
    std::size_t triangles = 0;
    for (const Fragment& fragment : f.set.fragments)
      for (const FragmentPrimitive& primitive : fragment.primitives) {
        ASSERT_NE(primitive.material, kInteriorMaterial);
        ASSERT_EQ(primitive.index_count, 3u);
        ++triangles;
        const auto& source = mesh.triangles[primitive.material];
        for (std::uint32_t c = 0; c < 3; ++c) {
          const Vec3d exact = to_double(mesh.positions[source[c]]) - fragment.pivot;
          const Vec3f local{static_cast<float>(exact.x), static_cast<float>(exact.y),
                            static_cast<float>(exact.z)};
          EXPECT_EQ(fragment.positions[fragment.indices[primitive.first_index + c]], local);
        }
      }
    EXPECT_EQ(triangles, mesh.triangles.size());
    EXPECT_EQ(f.set.fragments.size(), f.solid.parts.size());
  }
}

TEST(FractureGroups, EveryThirdCellGroupedKeepsAllInvariants) {
  std::size_t input = 0;
  for (const NamedMesh& shape : all_closed_shapes()) {
    SCOPED_TRACE(shape.name);
    const Mesh mesh = with_traced_triangles(shape.mesh);
    ++input;
    std::size_t turn = 0;
    for (const std::uint32_t groups : {2u, 5u, 17u}) {
      if (!has_turn(input, turn++, 3)) continue;
      SCOPED_TRACE(groups);
      PointsPattern pattern{random_sites(box_of(mesh), 60, kSeed)};
      for (std::uint32_t k = 0; k < pattern.points.size(); ++k) pattern.groups.push_back(k * 7919 % groups);
      FractureParameters p;
      p.pattern = std::move(pattern);
      const Fractured f = fracture_mesh(mesh, p);
      expect_closed(f.set);
      expect_partition(f.set, volume_of(mesh), area_of(mesh));
      expect_outside_untouched(f.set, mesh);
    }
  }
}

// ---- islands and cavities

TEST(FractureIslands, AShellAroundAFragmentKeepsItsCavity) {
  // One site: the whole body is one cell with its uncut cavities.
  const Mesh mesh = nested_spheres(4, 800);  // two parts with a cavity each
  const Fractured f = fracture_mesh(mesh, at_points({{0.1, 0.2, 0.3}}));
  ASSERT_EQ(f.set.fragments.size(), 2u);
  expect_closed(f.set);
  expect_partition(f.set, volume_of(mesh), area_of(mesh));
}

TEST(FractureIslands, AnnularCapsAndNestedShellsAcrossSeveralCells) {
  const Mesh mesh = nested_spheres(3, 800);  // outward, inward, outward
  for (const std::uint32_t count : {2u, 3u, 8u, 40u}) {
    SCOPED_TRACE(count);
    const Fractured f =
        fracture_mesh(with_traced_triangles(mesh), at_points(random_sites(box_of(mesh), count, kSeed)));
    expect_closed(f.set);
    expect_partition(f.set, volume_of(mesh), area_of(mesh));
    EXPECT_EQ(f.set.certificate.crossing_caps, 0u);
  }
  // Two sites whose bisector passes through the centre: the hollow part gets an annular cap, the ball inside
  // it a disk.
  const Fractured f = fracture_mesh(mesh, at_points({{-0.5, 0.01, 0}, {0.5, 0, 0.02}}));
  EXPECT_EQ(f.set.fragments.size(), 4u);
  EXPECT_EQ(f.set.bonds.size(), 2u);
}

TEST(FractureIslands, SelfCrossingSurfacesStayClosedAndKeepTheirSignedVolume) {
  for (const std::uint32_t count : {1u, 10u, 200u}) {
    const Mesh mesh = self_crossing_tube();
    const Fractured f = fracture_mesh(mesh, at_points(random_sites(box_of(mesh), count, kSeed)));
    expect_closed(f.set);
    EXPECT_LT(f.set.certificate.relative_error, 1e-9);
    EXPECT_EQ(f.set.certificate.open_edges, 0u);
  }
}

// ---- scale

TEST(FractureScale, TenThousandSites) {
  const Mesh mesh = sphere_with(2000);
  const Fractured f =
      fracture_mesh(mesh, at_points(random_sites(box_of(mesh), sized(2'000u, 10'000u), kSeed)), 2);
  expect_closed(f.set);
  expect_partition(f.set, volume_of(mesh), area_of(mesh));
}

TEST(FractureThreads, SameFragmentsForOneAndTwoThreads) {
  std::size_t input = 0;
  for (const NamedMesh& shape : all_closed_shapes()) {
    if (!has_turn(input++, 0, 3)) continue;
    SCOPED_TRACE(shape.name);
    const FractureParameters p = at_points(random_sites(box_of(shape.mesh), 300, kSeed));
    const FragmentSet a = fracture_mesh(shape.mesh, p, 1).set, b = fracture_mesh(shape.mesh, p, 2).set;
    ASSERT_EQ(a.fragments.size(), b.fragments.size());
    for (std::size_t k = 0; k < a.fragments.size(); ++k) {
      EXPECT_EQ(a.fragments[k].id, b.fragments[k].id);
      EXPECT_EQ(a.fragments[k].positions, b.fragments[k].positions);
      EXPECT_EQ(a.fragments[k].indices, b.fragments[k].indices);
      EXPECT_EQ(a.fragments[k].mass.volume, b.fragments[k].mass.volume);
    }
  }
}

}  // namespace
}  // namespace fracture::test
