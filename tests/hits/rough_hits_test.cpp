// Hits on answers with rough cuts. They equal the answer from scratch to the bit.
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/materials/materials.hpp"
#include "tests/hits/delta_checks.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

FractureParameters rough_hits_on(const Mesh& mesh, std::uint32_t sites, double radius,
                                 std::uint64_t seed = 7) {
  FractureParameters p = hits_on(mesh, sites, radius, seed);
  p.roughness = {0.06, 5, 2};
  return p;
}

TEST(RoughHits, AreLocalOnClosedShapes) {
  int local = 0, shapes = 0;
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 2, 3)) continue;
    SCOPED_TRACE(shape.name);
    local += expect_hits(shape.mesh, rough_hits_on(shape.mesh, 60, 0.12)) > 0;
    ++shapes;
    if (HasFailure()) return;
  }
  EXPECT_EQ(local, shapes);
}

TEST(RoughHits, InAStretchedDiagramAndWithGrains) {
  const Mesh mesh =
      joined({box({-1, -0.2, -0.2}, {1, 0.2, 0.2}, 4), box({-0.2, 0.3, -0.2}, {0.2, 2, 0.2}, 4)});
  FractureParameters p = rough_hits_on(mesh, 80, 0.1);
  p.roughness = {0.03, 6, 1};
  p.hits[0].point = {0.8, 0.2, 0};
  p.hits[1].point = {0.2, 1.5, 0};
  p.anisotropy = {.stretch = 3, .grain_of = GrainOf::kPart};
  EXPECT_EQ(expect_hits(mesh, p), 3);
  p.anisotropy = {.stretch = 2};
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(RoughHits, OfPartsThatOverlap) {
  const Mesh mesh = joined({ico_sphere(3), translated(ico_sphere(2), {0.6, 0.1, 0}), torus(32, 16)});
  expect_hits(mesh, rough_hits_on(mesh, sized(50u, 100u), 0.1), 2);
}

TEST(RoughHits, OfCellsWithSeveralPieces) {
  EXPECT_EQ(expect_hits(cube_field(4), rough_hits_on(cube_field(4), 30, 0.1)), 3);
  const Mesh rings = joined({torus(32, 16), translated(torus(32, 16), {0, 0, 0.9})});
  FractureParameters p = rough_hits_on(rings, 40, 0.1);
  p.roughness.amplitude = 0.12;
  EXPECT_EQ(expect_hits(rings, p), 3);
}

// A hit may break off pieces of a hundredth of the limit.
TEST(RoughHits, WithASmallestVolume) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = rough_hits_on(mesh, 60, 0.15);
  p.size.min_of_mean = 1e-3;
  EXPECT_EQ(expect_hits(mesh, p), 3);
  p.size = {.min_fraction = 0.02};
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(RoughHits, OfMaterials) {
  const Mesh mesh = ico_sphere(3);
  for (const char* name : {"stone", "metal", "sandstone"}) {
    SCOPED_TRACE(name);
    const MaterialPreset& preset = *find_material_preset(name);
    FractureParameters p = hits_on(mesh, 60, 0.12);
    p.pattern = preset.pattern;
    p.lloyd = preset.lloyd;
    p.anisotropy = {.stretch = preset.stretch, .grain = preset.grain};
    p.roughness = preset.roughness;
    p.size.min_of_mean = kLeastOfMean;
    EXPECT_EQ(expect_hits(mesh, p), 3);
  }
}

TEST(RoughHits, WithLevelsAndAnchorsAndOnesThatMiss) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = rough_hits_on(mesh, 60, 0.15);
  p.levels = {4, 12};
  p.anchors.points = {{1, 0, 0}};
  p.hits[1].point = {0, 100, 0};
  p.size.min_of_mean = 1e-3;
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(RoughHits, ForManySeeds) {
  if (!std::getenv("FRACTURE_TEST_FULL")) GTEST_SKIP() << "only with FRACTURE_TEST_FULL";
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    for (const NamedMesh& shape : closed_shapes()) {
      SCOPED_TRACE(shape.name + ", seed " + std::to_string(seed));
      FractureParameters p = rough_hits_on(shape.mesh, static_cast<std::uint32_t>(20 + 25 * seed), 0.1, seed);
      p.roughness.amplitude = 0.02 * static_cast<double>(seed);
      expect_hits(shape.mesh, p);
      if (HasFailure()) return;
    }
}

class RoughHitsOnMesh : public OnClosedMesh {};

TEST_P(RoughHitsOnMesh, EqualTheWholeFracture) {
  FractureParameters p = rough_hits_on(mesh, sized(20u, 60u), 0.1);
  p.hits.resize(sized(1u, 2u));
  expect_hits(mesh, p);
}

INSTANTIATE_TEST_SUITE_P(Dev, RoughHitsOnMesh, every_closed_mesh(), name_of_mesh);

}  // namespace
}  // namespace fracture::test
