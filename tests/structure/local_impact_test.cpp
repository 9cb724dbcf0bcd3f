// A hit breaks only its surroundings. A fragment is fractured again by its id.
#include "common/pipeline/local_impact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/property/judge.hpp"
#include "tests/structure/seed.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

FractureParameters hit(const Mesh& mesh, LocalRest rest) {
  FractureParameters p;
  p.sites = 60;
  p.seed = kSeed;
  const Box box = box_of(mesh);
  p.hits = {{box.center() + 0.5 * Vec3d{box.size().x, 0, 0}, 0.25 * box.longest_side(), 15}};
  p.rest = rest;
  return p;
}

TEST(LocalImpact, RestStaysOnePieceAndAllInvariantsHold) {
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 1, 3)) continue;
    SCOPED_TRACE(shape.name);
    const Mesh mesh = with_traced_triangles(shape.mesh);
    const FractureParameters p = hit(mesh, LocalRest::kWhole);
    const Fractured f = fracture_mesh(mesh, p);
    expect_closed(f.set);
    expect_partition(f.set, volume_of(mesh), area_of(mesh));
    expect_outside_untouched(f.set, mesh);
    const double largest =
        std::max_element(f.set.fragments.begin(), f.set.fragments.end(),
                         [](const Fragment& a, const Fragment& b) { return a.mass.volume < b.mass.volume; })
            ->mass.volume;
    const double ball = 4.0 / 3 * 3.14159265 * std::pow(1.25 * p.hits[0].radius, 3);
    if (f.solid.parts.size() == 1) {
      EXPECT_GT(largest, 0.5 * (f.solid.report.volume - ball));
    }
  }
}

TEST(LocalImpact, FragmentsFarAwayKeepIdAndShape) {
  const Mesh mesh = torus(48, 24);
  FractureParameters p = hit(mesh, LocalRest::kFractured);
  const FragmentSet after = fracture_mesh(mesh, p).set;
  p.hits.clear();
  const Fractured before = fracture_mesh(mesh, p);
  std::size_t same = 0;
  for (const Fragment& f : before.set.fragments) {
    const auto at = std::find_if(after.fragments.begin(), after.fragments.end(),
                                 [&](const Fragment& x) { return x.id == f.id; });
    if (at != after.fragments.end() && std::fabs(at->mass.volume - f.mass.volume) < 1e-12) ++same;
  }
  EXPECT_GT(same, before.set.fragments.size() / 3);
  EXPECT_LT(same, before.set.fragments.size());
  EXPECT_GT(after.fragments.size(), before.set.fragments.size());
}

TEST(LocalImpact, AHitBesideTheSolidBreaksNothingAndSaysSo) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p = hit(mesh, LocalRest::kFractured);
  p.hits[0].point = {0, 10 * box_of(mesh).longest_side(), 0};
  const Fractured made = fracture_mesh(mesh, p);
  const FragmentSet& after = made.set;
  p.hits.clear();
  const FragmentSet before = fracture_mesh(mesh, p).set;
  ASSERT_EQ(after.fragments.size(), before.fragments.size());
  for (std::size_t k = 0; k < after.fragments.size(); ++k)
    EXPECT_EQ(after.fragments[k].id, before.fragments[k].id);
  EXPECT_TRUE(warns(made.report, "Hit 1 breaks nothing off, because 0,"));
  EXPECT_TRUE(warns(made.report, " m from the mesh, but 'local_radius' is only "));
}

TEST(LocalImpact, ASecondHitAtTheSamePlaceBreaksFurther) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p = hit(mesh, LocalRest::kFractured);
  const std::size_t once = fracture_mesh(mesh, p).set.fragments.size();
  p.hits.push_back(p.hits[0]);
  EXPECT_GT(fracture_mesh(mesh, p).set.fragments.size(), once + 5);
}

// The limit applies to the total number of sites, not to each hit.
TEST(LocalImpact, HitsTogetherKeepToTheMostSites) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p = hit(mesh, LocalRest::kFractured);
  p.hits.push_back(p.hits[0]);
  Execution execution;
  StageTimings timings;
  const Solid solid = solid_of(mesh);
  p.most_sites = 90;
  EXPECT_TRUE(make_diagram(solid, p, execution, timings));
  for (const auto& [cells, most] : {std::pair{1u, 89u}, {1u, 60u}, {4u, 350u}}) {
    p.aggregation.cells = cells;
    p.most_sites = most;
    const Expected<Diagram> diagram = make_diagram(solid, p, execution, timings);
    ASSERT_FALSE(diagram) << most;
    EXPECT_EQ(diagram.error().code, ErrorCode::kTooComplex);
    EXPECT_EQ(diagram.error().pointer, "local_sites");
  }
  p.most_sites = 59;
  p.aggregation.cells = 1;
  EXPECT_EQ(make_diagram(solid, p, execution, timings).error().pointer, "sites");
}

TEST(FractureAgain, MakesNoMoreSitesThanThereMayBe) {
  const Mesh mesh = cube();
  Execution execution;
  StageTimings timings;
  const Solid solid = solid_of(mesh);
  FractureParameters p;
  p.sites = 10;
  p.most_sites = 30;
  const Expected<Diagram> diagram = make_diagram(solid, p, execution, timings);
  ASSERT_TRUE(diagram);
  const std::uint64_t id = fracture_mesh(mesh, p).set.fragments[0].id;
  EXPECT_TRUE(refracture(solid, *diagram, p, {id, 30, 5}, execution, timings));
  const Expected<FracturedSolid> parts = refracture(solid, *diagram, p, {id, 31, 5}, execution, timings);
  ASSERT_FALSE(parts);
  EXPECT_EQ(parts.error().code, ErrorCode::kTooComplex);
}

TEST(FractureAgain, PartsOfTheFragmentWithThisIdAreTheAnswer) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p;
  p.sites = 12;
  const FragmentSet whole = fracture_mesh(mesh, p).set;
  const Fragment& one = whole.fragments.at(3);
  const FracturedSolid again = fracture_mesh_again(mesh, p, {one.id, 6, 5});
  const FragmentSet& parts = again.set;
  EXPECT_GT(parts.fragments.size(), 1u);
  expect_closed(parts);
  double volume = 0;
  for (const Fragment& f : parts.fragments) volume += f.mass.volume;
  EXPECT_NEAR(volume, one.mass.volume, 1e-6 * one.mass.volume);
  EXPECT_EQ(again.report.fragment.value().id, one.id);
}

TEST(FractureAgain, UnknownIdIsAnError) {
  const Mesh mesh = cube();
  Execution execution;
  StageTimings timings;
  const Solid solid = solid_of(mesh);
  FractureParameters p;
  const Expected<Diagram> diagram = make_diagram(solid, p, execution, timings);
  ASSERT_TRUE(diagram);
  const Expected<FracturedSolid> parts = refracture(solid, *diagram, p, {12345, 6, 5}, execution, timings);
  ASSERT_FALSE(parts);
  EXPECT_EQ(parts.error().code, ErrorCode::kNoSuchFragment);
  EXPECT_EQ(parts.error().pointer, "fragment");
}

}  // namespace
}  // namespace fracture::test
