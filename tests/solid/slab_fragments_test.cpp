// Open sheets that became slabs and were fractured. The fragments must be closed and add up to the solid.
#include <gtest/gtest.h>

#include <cmath>

#include "common/pipeline/fracture.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/surface_mesh.hpp"

namespace fracture::test {
namespace {

/// The smallest of the meshes that failed: a triangle and its reverse over the same three wedges, with
/// normals.
Mesh two_sided_triangle() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.attributes.normals.assign(3, {0, 0, 1});
  mesh.triangles = {{0, 1, 2}, {2, 1, 0}};
  mesh.material.assign(2, kNoIndex);
  mesh.node.assign(2, 0);
  mesh.node_names = {"sheet"};
  return mesh;
}

void expect_sound_fragments(const Mesh& mesh, double thickness, std::uint32_t sites) {
  SCOPED_TRACE("thickness " + std::to_string(thickness) + ", sites " + std::to_string(sites));
  StageTimings timings;
  const Expected<Solid> solid = make_solid(std::make_shared<const Mesh>(mesh), {.thickness = thickness}, {});
  if (!solid) return;  // a typed refusal
  ASSERT_NO_THROW(solid->validate());
  const Mesh surface = surface_mesh(*solid);
  ASSERT_EQ(open_directed_edges(surface), 0u);
  EXPECT_NEAR(volume_of(surface), solid->report.volume, 1e-9 * solid->report.volume);
  FractureParameters parameters;
  parameters.sites = sites;
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, {}, timings);
  ASSERT_TRUE(diagram);
  const Expected<FracturedSolid> made = fracture(*solid, *diagram, parameters, {}, timings);
  ASSERT_TRUE(made);
  const Certificate& certificate = made->set.certificate;
  EXPECT_EQ(certificate.open_edges, 0u);
  EXPECT_LT(certificate.relative_error, 1e-9);
  EXPECT_NEAR(certificate.volume_file + certificate.pocket_volume, solid->report.volume,
              1e-4 * solid->report.volume);
}

TEST(SlabFragments, ASheetWhoseSidesShareTheirWedgesIsSound) {
  for (const double thickness : {0.01, 0.5})
    for (const std::uint32_t sites : {1u, 2u, 30u})
      expect_sound_fragments(two_sided_triangle(), thickness, sites);
}

TEST(SlabFragments, EveryFileIsSoundWithEveryThickness) {
  std::size_t seen = 0;
  for (const MeshFile& file : test_meshes()) {
    const Expected<Mesh> mesh = load_mesh(file);
    if (!mesh || mesh->triangles.size() > 20'000) continue;
    SCOPED_TRACE(file.name);
    ++seen;
    for (const double thickness : {0.001, 0.01, 0.1, 0.5}) expect_sound_fragments(*mesh, thickness, 30);
  }
  if (seen == 0) GTEST_SKIP() << "no test meshes";
}

// 23 thick slabs inside one another. If the surfaces of a group of pieces cancel, the group has no face and
// is not a fragment.
TEST(SlabFragments, UnitedPiecesThatCancelAreNoFragment) {
  for (const MeshFile& file : test_meshes()) {
    if (file.name != "kk_wall.glb") continue;
    const Expected<Mesh> mesh = load_mesh(file);
    ASSERT_TRUE(mesh);
    StageTimings timings;
    const Expected<Solid> solid =
        make_solid(std::make_shared<const Mesh>(*mesh),
                   {.weld_tolerance = 9.083366330064085e-06, .thickness = 6.394018731080077}, {});
    ASSERT_TRUE(solid);
    FractureParameters parameters;
    parameters.sites = 5;
    parameters.seed = 7055637778685888;
    ImpactPattern ice;
    ice.impacts = {{-0.9623808250309636, 2.938613477004627, -0.4218562971706128},
                   {1.0953174126281104, 1.246933055131349, 0.12855766313087225},
                   {-0.5778884587772204, 3.338889738937354, -0.1904756946119731}};
    ice.exponent = 1.8;
    ice.share = 0.5;
    parameters.pattern = ice;
    parameters.size.min_fraction = 0.5072634819798832;
    parameters.roughness = {0.04, 3, 4};
    const Expected<Diagram> diagram = make_diagram(*solid, parameters, {}, timings);
    ASSERT_TRUE(diagram);
    const Expected<FracturedSolid> made = fracture(*solid, *diagram, parameters, {}, timings);
    ASSERT_TRUE(made);
    EXPECT_EQ(made->set.certificate.open_edges, 0u);
    for (const Fragment& f : made->set.fragments) EXPECT_FALSE(f.indices.empty()) << f.id;
    return;
  }
  GTEST_SKIP() << "no kk_wall.glb";
}

}  // namespace
}  // namespace fracture::test
