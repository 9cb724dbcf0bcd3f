// Hits on answers in which size limits have united pieces. Pieces stay united, and the answer equals the one
// from scratch to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "common/base/processor_time.hpp"
#include "common/materials/materials.hpp"
#include "tests/hits/delta_checks.hpp"
#include "tests/physics/bent_shapes.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

FractureParameters united_on(const Mesh& mesh, std::uint32_t sites, double radius, std::uint64_t seed = 5) {
  FractureParameters p = hits_on(mesh, sites, radius, seed);
  p.size.min_of_mean = 0.3;
  return p;
}

std::uint32_t united_without_hits(const Mesh& mesh, FractureParameters p) {
  p.hits.clear();
  return fracture_mesh(mesh, p).set.size.united;
}

TEST(UnitedHits, AreLocalOnClosedShapes) {
  int local = 0, with_unions = 0;
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 0, 2)) continue;
    SCOPED_TRACE(shape.name);
    const FractureParameters p = united_on(shape.mesh, 60, 0.1);
    if (united_without_hits(shape.mesh, p) == 0) continue;
    ++with_unions;
    local += expect_hits(shape.mesh, p) > 0;
    if (HasFailure()) return;
  }
  EXPECT_GE(with_unions, sized(2, 5)) << "or nothing is tested here";
  EXPECT_EQ(local, with_unions);
}

TEST(UnitedHits, WithRoughCuts) {
  const Mesh mesh = torus(48, 24);
  FractureParameters p = united_on(mesh, 120, 0.08);
  p.roughness = {0.03, 6, 1};
  ASSERT_GT(united_without_hits(mesh, p), 3u);
  EXPECT_EQ(expect_hits(mesh, p, 2), 3);
}

TEST(UnitedHits, OnANumberOfFragments) {
  const Mesh mesh = torus(48, 24);
  FractureParameters p = hits_on(mesh, 90, 0.1);
  p.size.fragments = 40;
  p.size.min_of_mean = kLeastOfMean;
  ASSERT_GT(united_without_hits(mesh, p), 30u);
  EXPECT_EQ(expect_hits(mesh, p), 3);
  p.hits.clear();
  EXPECT_EQ(fracture_mesh(mesh, p).set.fragments.size(), 40u);
}

TEST(UnitedHits, OnAggregatesWithSeveralPieces) {
  const Mesh mesh = cube_field(4);
  FractureParameters p = united_on(mesh, 20, 0.08);
  p.aggregation = {4, 1};
  expect_hits(mesh, p);
}

TEST(UnitedHits, InAStretchedDiagram) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = united_on(mesh, 120, 0.08);
  p.anisotropy = {.stretch = 4, .grain_of = GrainOf::kPart};
  ASSERT_GT(united_without_hits(mesh, p), 3u);
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

/// Hits with splinters smaller than a hundredth of the limit, so that splinters are united with the rest of the
/// fragment that they broke from.
FractureParameters with_splinters(const Mesh& mesh, std::uint64_t seed) {
  FractureParameters p = hits_on(mesh, 200, 0.02, seed);
  p.hits.erase(p.hits.begin());  // it misses some of the shapes
  for (LocalImpact& hit : p.hits) hit.sites = 200;
  p.size.min_of_mean = 0.025;
  return p;
}

TEST(UnitedHits, WhoseSplintersAreTooSmall) {
  const Mesh mesh = torus(48, 24);
  for (const double amplitude : {0.0, 0.01}) {
    SCOPED_TRACE(amplitude);
    FractureParameters p = with_splinters(mesh, 5);
    p.roughness = {amplitude, 6, 1};
    EXPECT_EQ(expect_hits(mesh, p), 2);
    const std::uint32_t united = fracture_mesh(mesh, p).set.size.united;
    EXPECT_GE(united, united_without_hits(mesh, p) + 3) << "or nothing is tested here";
  }
}

// A hit takes its pieces from the fragments next to it, and from no other.
TEST(UnitedHits, LeaveWhatTheyAreNotNearTo) {
  const Mesh mesh = torus(48, 24);
  FractureParameters p = united_on(mesh, 200, 0.05);
  p.size.min_of_mean = 0.6;
  p.hits.resize(1);
  const FracturedSolid after = fracture_mesh(mesh, p);
  const FracturedSolid before = fracture_mesh(mesh, before_hits(p, 1));
  ASSERT_GT(before.set.size.united, 20u);
  std::set<std::uint64_t> there;
  for (const Fragment& f : after.set.fragments) there.insert(f.id);
  std::size_t gone = 0;
  for (const Fragment& f : before.set.fragments) {
    if (there.contains(f.id)) continue;
    ++gone;
    EXPECT_LT(length(f.mass.center_of_mass - p.hits[0].point), 1) << "a fragment far from the hit is gone";
  }
  EXPECT_LT(gone, 15u) << "of " << before.set.fragments.size();
}

TEST(UnitedHits, OfPanesHitAwayFromWhereTheyWereHitBefore) {
  const Mesh mesh = box({0, 0, 0}, {1, 1, 0.02}, 1);
  for (std::uint64_t seed = 1; seed <= sized(2u, 5u); ++seed) {
    SCOPED_TRACE(seed);
    FractureParameters p;
    RadialPattern glass;
    glass.impacts = {{0, 0, 0.01}};
    p.pattern = glass;
    p.seed = seed;
    p.size.fragments = 40;
    p.size.min_of_mean = kLeastOfMean;
    p.rest = LocalRest::kFractured;
    p.hits = {{{0.5, 0.5, 0.01}, 0.1, 30}};
    expect_hits(mesh, p);
    if (HasFailure()) return;
  }
}

// The additional sites of max_volume are not hits: they take nothing apart.
TEST(UnitedHits, WithCellsThatWereTooLarge) {
  const Mesh mesh = torus(48, 24);
  FractureParameters p = hits_on(mesh, 100, 0.05);
  p.hits.resize(1);
  p.size.fragments = 80;
  p.max_volume = volume_of(mesh) / 150;
  const Fractured after = fracture_mesh(mesh, p);
  const Fractured before = fracture_mesh(mesh, before_hits(p, 1));
  ASSERT_GT(before.diagram.split.sites_added, 30u);
  EXPECT_EQ(after.diagram.split, before.diagram.split);
  ASSERT_EQ(before.set.fragments.size(), 80u);
  ASSERT_GT(before.diagram.tetrahedralization.site_count(), 150u);
  EXPECT_LT(after.set.fragments.size(), 110u);
}

// Two fragments contain half of all cells each. The fragments next to a hit are then most of the answer, but
// the work must not grow with the square.
TEST(UnitedHits, OfVeryManyCellsTakeNoLongerThanTheWhole) {
  const Mesh mesh = ico_sphere(3);
  FractureParameters p = hits_on(mesh, 12'000, 0.02);
  p.hits.resize(1);
  p.size.fragments = 2;
  p.size.min_of_mean = kLeastOfMean;
  const Solid solid = solid_of(mesh);
  StageTimings timings;
  const double begin = processor_seconds_of_this_thread();
  const auto before = fracture_and_keep(solid, before_hits(p, 1), {}, timings);
  ASSERT_TRUE(before);
  const double whole = processor_seconds_of_this_thread() - begin;
  const auto after = fracture_delta(solid, before->base, p, {}, {}, timings);
  ASSERT_TRUE(after);
  EXPECT_TRUE(after->local) << "or nothing is tested here";
  const double hit = processor_seconds_of_this_thread() - begin - whole;
  EXPECT_LT(hit, 3 * whole + 0.1);
}

TEST(UnitedHits, OfEveryMaterial) {
  const Mesh mesh = ico_sphere(3);
  int local = 0, materials = 0;
  for (const MaterialPreset& preset : material_presets()) {
    SCOPED_TRACE(preset.name);
    FractureParameters p = hits_on(mesh, sized(25u, 50u), 0.1);
    p.pattern = preset.pattern;
    p.lloyd = preset.lloyd;
    p.anisotropy = {.stretch = preset.stretch, .grain = preset.grain};
    if (!preset.grain && preset.stretch != 1) p.anisotropy.grain_of = GrainOf::kPart;
    p.roughness = preset.roughness;
    p.aggregation = preset.aggregation;
    p.size.min_of_mean = kLeastOfMean;
    p.hits.resize(sized(1u, 2u));
    ++materials;
    local += expect_hits(mesh, p) > 0;
    if (HasFailure()) return;
  }
  EXPECT_EQ(local, materials);
}

TEST(UnitedHits, WhoseSplintersAreTooSmallForManySeeds) {
  if (!std::getenv("FRACTURE_TEST_FULL")) GTEST_SKIP() << "only with FRACTURE_TEST_FULL";
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    for (const NamedMesh& shape : closed_shapes()) {
      SCOPED_TRACE(shape.name + ", seed " + std::to_string(seed));
      FractureParameters p = with_splinters(shape.mesh, seed);
      expect_hits(shape.mesh, p);
      p.roughness = {0.03, 6, 1};
      expect_hits(shape.mesh, p);
      if (HasFailure()) return;
    }
}

TEST(UnitedHits, ForManySeeds) {
  if (!std::getenv("FRACTURE_TEST_FULL")) GTEST_SKIP() << "only with FRACTURE_TEST_FULL";
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    for (const NamedMesh& shape : closed_shapes()) {
      SCOPED_TRACE(shape.name + ", seed " + std::to_string(seed));
      FractureParameters p = united_on(shape.mesh, static_cast<std::uint32_t>(20 + 20 * seed), 0.08, seed);
      if (seed % 2 == 0) p.roughness = {0.01 * static_cast<double>(seed), 5, 2};
      if (seed % 3 == 0) p.aggregation.cells = 3;
      expect_hits(shape.mesh, p);
      if (HasFailure()) return;
    }
}

class UnitedHitsOnMesh : public OnClosedMesh {};

TEST_P(UnitedHitsOnMesh, EqualTheWholeFracture) {
  FractureParameters p = united_on(mesh, sized(20u, 60u), 0.1);
  p.hits.resize(sized(1u, 2u));
  expect_hits(mesh, p);
}

INSTANTIATE_TEST_SUITE_P(Dev, UnitedHitsOnMesh, every_closed_mesh(), name_of_mesh);

// A hit remakes only some cells: their hulls, and the largest excess of all, are those of the whole answer.
TEST(UnitedHits, WhereHullsAreDividedAndShared) {
  const Mesh frame = grid_solid(
      {{{-1, -0.8, 0.8, 1}, {-1, -0.8, 0.8, 1}, {-0.1, 0.1}}},
      [](int i, int j, int) { return i != 1 || j != 1; }, 3);
  for (const double rough : {0.0, 0.02}) {
    SCOPED_TRACE(rough);
    FractureParameters p = hits_on(frame, 16, 0.1);
    p.size.min_of_mean = 0.5;
    p.roughness.amplitude = rough;
    p.hull_limits = {1.05, 3};
    EXPECT_EQ(expect_hits(frame, p), 3);
  }
}

}  // namespace
}  // namespace fracture::test
