// Hits on answers whose fragments contain several cells. They equal the answer from scratch to the bit.
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/materials/materials.hpp"
#include "tests/hits/delta_checks.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

FractureParameters aggregates_on(const Mesh& mesh, std::uint32_t fragments, double radius,
                                 std::uint64_t seed = 3) {
  FractureParameters p = hits_on(mesh, fragments, radius, seed);
  p.aggregation = {4, 1};
  return p;
}

TEST(GroupedHits, OnAggregatesAreLocalOnClosedShapes) {
  int local = 0, shapes = 0;
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 1, 3)) continue;
    SCOPED_TRACE(shape.name);
    local += expect_hits(shape.mesh, aggregates_on(shape.mesh, 30, 0.12)) > 0;
    ++shapes;
    if (HasFailure()) return;
  }
  EXPECT_EQ(local, shapes);
}

TEST(GroupedHits, OfSeveralSeedsWithOneHullAndWithTwoThreads) {
  const Mesh mesh = torus(48, 24);
  for (std::uint64_t seed = 1; seed <= sized(2u, 4u); ++seed) {
    SCOPED_TRACE(seed);
    FractureParameters p = aggregates_on(mesh, 60, 0.1, seed);
    p.hull_limits.count = static_cast<std::uint32_t>(seed);
    EXPECT_EQ(expect_hits(mesh, p, 2), 3);
  }
}

TEST(GroupedHits, OnRoughAggregates) {
  const Mesh mesh = ico_sphere(3);
  FractureParameters p = aggregates_on(mesh, 60, 0.1);
  p.roughness = {0.04, 5, 2};
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(GroupedHits, OnBricksWithMortarKeepTheJoints) {
  const Mesh mesh = box({0, 0, 0}, {2.4, 1.5, 0.24}, 3);
  FractureParameters p = hits_on(mesh, 40, 0.06);
  p.pattern = BrickPattern{.jitter = 0.05, .impacts = {{1.2, 0.7, 0.24}}, .mortar = true};
  EXPECT_EQ(expect_hits(mesh, p), 3);
  EXPECT_EQ(expect_hits(mesh, p, 2), 3);
}

TEST(GroupedHits, InAStretchedDiagram) {
  const Mesh mesh = ico_sphere(3);
  FractureParameters p = aggregates_on(mesh, 40, 0.12);
  p.anisotropy = {.stretch = 3, .grain_of = GrainOf::kPart};
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

// Aggregates around an impact follow the cracks. Hits on them have cells that stay together, too.
TEST(GroupedHits, OnAggregatesAroundAnImpact) {
  const Mesh mesh = ico_sphere(3);
  FractureParameters p = aggregates_on(mesh, 60, 0.1);
  p.pattern = ImpactPattern{.impacts = {{0.9, 0.1, 0}}};
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

// A group of cells. Some of the cells have several pieces.
TEST(GroupedHits, OfManyPieces) {
  const Mesh mesh = cube_field(4);
  EXPECT_EQ(expect_hits(mesh, aggregates_on(mesh, 12, 0.1)), 3);
}

TEST(GroupedHits, OnLumpsOfBricks) {
  const Mesh mesh = box({-2, 0, -0.1}, {2, 1.5, 0.1}, 6);
  FractureParameters p = hits_on(mesh, 60, 0.08);
  p.pattern = BrickPattern{};
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

// A plate, rods and a body, each with its own frame.
TEST(GroupedHits, OnAThingOfGlassWhosePartsBreakByTheirShape) {
  std::vector<Mesh> parts{box({0, 1, 0}, {3, 1.1, 1}, 4), translated(ico_sphere(3), {1.5, 2.1, 0.5})};
  for (const double x : {0.1, 2.7})
    for (const double z : {0.1, 0.7}) parts.push_back(box({x, 0, z}, {x + 0.2, 1, z + 0.2}, 4));
  const Mesh mesh = joined(parts);
  for (const double rough : {0.0, 0.06}) {
    SCOPED_TRACE(rough);
    FractureParameters p = hits_on(mesh, 120, 0.12);
    p.pattern = RadialPattern{.around = RadialPattern::Around::kShape, .impacts = {{2, 1.1, 0.5}}};
    p.roughness.amplitude = rough;
    ASSERT_EQ(p.hits.size(), 3u);
    p.hits[0].point = {0.2, 0.5, 0.2};  // on a leg
    p.hits[1].point = {0.2, 1.0, 0.2};  // where the leg meets the top
    p.hits[2].point = {1.5, 1.1, 0.5};  // where the ball meets the top
    EXPECT_EQ(expect_hits(mesh, p), 3);
  }
}

TEST(GroupedHits, ThatMissAndThatMeetAgain) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = aggregates_on(mesh, 40, 0.12);
  p.hits[0].point = {0, 100, 0};
  p.hits.push_back(p.hits.back());
  p.levels = {4, 12};
  p.anchors.points = {{1, 0, 0}};
  EXPECT_EQ(expect_hits(mesh, p), 4);
}

TEST(GroupedHits, OfMaterials) {
  const Mesh mesh = ico_sphere(3);
  for (const char* name : {"stone", "concrete"}) {
    SCOPED_TRACE(name);
    const MaterialPreset& preset = *find_material_preset(name);
    ASSERT_GT(preset.aggregation.cells, 1u);
    FractureParameters p = hits_on(mesh, 60, 0.1);
    p.pattern = preset.pattern;
    p.lloyd = preset.lloyd;
    p.anisotropy = {.stretch = preset.stretch, .grain = preset.grain};
    p.roughness = preset.roughness;
    p.aggregation = preset.aggregation;
    p.size.min_of_mean = kLeastOfMean;
    EXPECT_EQ(expect_hits(mesh, p), 3);
  }
}

TEST(GroupedHits, ForManySeeds) {
  if (!std::getenv("FRACTURE_TEST_FULL")) GTEST_SKIP() << "only with FRACTURE_TEST_FULL";
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    for (const NamedMesh& shape : closed_shapes()) {
      SCOPED_TRACE(shape.name + ", seed " + std::to_string(seed));
      FractureParameters p = aggregates_on(shape.mesh, static_cast<std::uint32_t>(8 + 15 * seed), 0.1, seed);
      p.aggregation.cells = static_cast<std::uint32_t>(1 + 2 * seed);
      if (seed % 2 == 0) p.roughness = {0.02 * static_cast<double>(seed), 5, 2};
      expect_hits(shape.mesh, p);
      if (HasFailure()) return;
    }
}

class GroupedHitsOnMesh : public OnClosedMesh {};

TEST_P(GroupedHitsOnMesh, EqualTheWholeFracture) {
  FractureParameters p = aggregates_on(mesh, sized(10u, 30u), 0.1);
  p.hits.resize(sized(1u, 2u));
  expect_hits(mesh, p);
}

INSTANTIATE_TEST_SUITE_P(Dev, GroupedHitsOnMesh, every_closed_mesh(), name_of_mesh);

}  // namespace
}  // namespace fracture::test
