// The answer to a hit on a stored answer equals the answer to all hits from scratch, bit for bit. Fragments that
// it calls unchanged equal those of the answer before.
#include "common/hits/delta.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "common/contacts/contacts.hpp"
#include "common/hits/difference.hpp"
#include "tests/hits/delta_checks.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

TEST(Delta, EqualsTheWholeFractureBitForBit) {
  int local = 0, shapes = 0;
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 0, 3)) continue;
    SCOPED_TRACE(shape.name);
    local += expect_hits(shape.mesh, hits_on(shape.mesh, 80, 0.15)) > 0;
    ++shapes;
    if (HasFailure()) return;
  }
  EXPECT_EQ(local, shapes);
}

TEST(Delta, EqualsTheWholeFractureForManySeeds) {
  if (!std::getenv("FRACTURE_TEST_FULL")) GTEST_SKIP() << "only with FRACTURE_TEST_FULL";
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const NamedMesh& shape : closed_shapes()) {
      SCOPED_TRACE(shape.name + ", seed " + std::to_string(seed));
      expect_hits(shape.mesh, hits_on(shape.mesh, static_cast<std::uint32_t>(10 + 11 * seed), 0.15, seed));
      if (HasFailure()) return;
    }
}

TEST(Delta, OfSeveralSeeds) {
  for (std::uint64_t seed = 1; seed <= sized(2u, 5u); ++seed) {
    SCOPED_TRACE(seed);
    EXPECT_EQ(expect_hits(torus(32, 16), hits_on(torus(32, 16), 40, 0.2, seed)), 3);
  }
}

TEST(Delta, WithSeamsAndAttributesAndTwoThreads) {
  const Mesh mesh = sphere_with_seams(24, 48);
  EXPECT_EQ(expect_hits(mesh, hits_on(mesh, 100, 0.12), 2), 3);
}

TEST(Delta, InAStretchedDiagram) {
  const Mesh mesh = ico_sphere(3);
  FractureParameters p = hits_on(mesh, 80, 0.15);
  p.anisotropy.stretch = 3;
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(Delta, WhereEachPartHasAGrainOfItsOwn) {
  const Mesh mesh =
      joined({box({-1, -0.2, -0.2}, {1, 0.2, 0.2}, 4), box({-0.2, 0.3, -0.2}, {0.2, 2, 0.2}, 4)});
  FractureParameters p = hits_on(mesh, 80, 0.15);
  p.anisotropy = {.stretch = 3, .grain_of = GrainOf::kPart};
  p.hits[0].point = {0.8, 0.2, 0};
  p.hits[1].point = {0.2, 1.5, 0};
  p.hits[2].point = {0, 0.25, 0};  // between the two parts
  EXPECT_EQ(expect_hits(mesh, p), 3);
  EXPECT_EQ(fracture_mesh(mesh, p).report.remarks, Remarks{}) << "all sites found a place";
}

// Inside both parts, two layers wind around a Voronoi vertex. Under a map they may be other layers.
TEST(Delta, OfPartsThatOverlap) {
  const Mesh mesh = joined(
      {ico_sphere(3), translated(ico_sphere(2), {0.6, 0.1, 0}), translated(ico_sphere(2), {-3, 0.1, 0})});
  FractureParameters p = hits_on(mesh, sized(40u, 80u), 0.2);
  p.filters = HullFilters::kNone;  // they would not be enough for all cells that both spheres share
  for (LocalImpact& hit : p.hits) hit.point = {0.3, 0.1, 0.2};
  EXPECT_EQ(expect_hits(mesh, p), 3);
  p.anisotropy.stretch = 2.5;
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(Delta, OfATableWhoseLegsStickIntoItsTop) {
  std::vector<Mesh> parts{box({0, 1, 0}, {2, 1.2, 1})};
  for (const double x : {0.1, 1.7})
    for (const double z : {0.1, 0.7}) parts.push_back(box({x, 0, z}, {x + 0.2, 1.05, z + 0.2}));
  const Mesh table = joined(parts);
  FractureParameters p = hits_on(table, 60, 0.15);
  p.anisotropy = {5, GrainOf::kPart};
  EXPECT_EQ(expect_hits(table, p),
            3);  // with filters and trimmed hulls; those of untouched bodies keep their bits
  p.hits.clear();
  StageTimings timings;
  Solid solid = *make_solid(std::make_shared<Mesh>(table), {}, {});
  keep_contacts(solid, {}, {});
  const RestFigures rest =
      fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings)->rest.value().figures;
  EXPECT_GT(rest.filtered, 0u) << "nothing is tested above";
  EXPECT_GT(rest.trimmed, 0u);
}

TEST(Delta, WhereFiltersRunOutHullsFarAwayMayChange) {
  std::vector<Mesh> parts;  // 40 pairs of rods that cross
  for (int k = 0; k < 40; ++k) {
    parts.push_back(box({0.5 * k, 0, -1}, {0.5 * k + 0.2, 0.2, 1}));
    parts.push_back(box({0.5 * k + 0.05, -1, -0.1}, {0.5 * k + 0.15, 1, 0.1}));
  }
  const Mesh rods = joined(parts);
  FractureParameters p = hits_on(rods, 4, 0.02);
  p.anisotropy = {5, GrainOf::kPart};
  EXPECT_EQ(expect_hits(rods, p), 3);
}

// Bonds across parts are computed again for changed fragments, in whichever cell the other fragment is.
TEST(Delta, OfPartsInContact) {
  std::vector<Mesh> parts{box({-2, 0, -0.3}, {2, 0.3, 0.3}, 2), box({-1.7, -2, -0.1}, {-1.5, 0.1, 0.1}, 2)};
  for (int k = 0; k < 4; ++k) parts.push_back(box({-2 + k * 1.0, 0.3, -0.3}, {-1 + k * 1.0, 0.7, 0.3}));
  const Mesh mesh = joined(parts);
  FractureParameters p = hits_on(mesh, 60, 0.1);
  p.hits[0].point = {-1.6, 0.1, 0};
  p.hits[1].point = {0, 0.3, 0};
  p.hits[2].point = {1, 0.35, 0.1};
  EXPECT_EQ(expect_hits(mesh, p), 3);
  p.anisotropy = {.stretch = 3, .grain_of = GrainOf::kPart};
  EXPECT_EQ(expect_hits(mesh, p), 3);
  p.contact_strength = 0.25;
  p.levels = {8};
  expect_hits(mesh, p);
}

// One cell with thousands of pieces: the comparison looks pieces up and does not search for them.
TEST(Delta, OfACellWithManyPieces) {
  const Mesh mesh = cube_field(8);
  FractureParameters p = hits_on(mesh, 1, 0.1);
  p.hits.resize(1);
  EXPECT_EQ(expect_hits(mesh, p), 1);
}

TEST(Delta, DeepInsideWhereNoVoronoiVertexLiesOutside) {
  const Mesh mesh = ico_sphere(3);
  FractureParameters p = hits_on(mesh, 400, 0.05);
  p.hits[0].point = p.hits[1].point = box_of(mesh).center();
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(Delta, OfOneCell) {
  const Mesh mesh = cube();
  EXPECT_EQ(expect_hits(mesh, hits_on(mesh, 1, 0.3)), 3);
}

TEST(Delta, BesideTheSolidNothingChanges) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p = hits_on(mesh, 30, 0.1);
  for (LocalImpact& hit : p.hits) hit.point = {0, 100, 0};
  expect_hits(mesh, p);
  FractureParameters limited = p;
  limited.size.min_of_mean = 1e-3;
  expect_hits(mesh, limited);
  Execution execution;
  StageTimings timings;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(mesh), {}, execution);
  ASSERT_TRUE(solid);
  const auto base = fracture_and_keep(*solid, before_hits(p, 3), execution, timings);
  ASSERT_TRUE(base);
  auto next = fracture_delta(*solid, base->base, p, {3}, execution, timings);
  ASSERT_TRUE(next);
  const FragmentSet& set = next->fractured.set;
  const Delta& delta = next->fractured.delta.value();
  EXPECT_TRUE(delta.added.empty() && delta.changed.empty() && delta.gone.empty());
  keep_changed(next->fractured);
  EXPECT_TRUE(set.fragments.empty() && set.bonds.empty());
}

TEST(Delta, OfSeveralNewHitsAtOnce) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = hits_on(mesh, 60, 0.15);
  Execution execution;
  StageTimings timings;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(mesh), {}, execution);
  ASSERT_TRUE(solid);
  const auto base = fracture_and_keep(*solid, before_hits(p, 2), execution, timings);
  ASSERT_TRUE(base);
  const auto next = fracture_delta(*solid, base->base, p, {2}, execution, timings);
  ASSERT_TRUE(next);
  const FracturedSolid after = fracture_mesh(mesh, p);
  expect_same(next->fractured, after);
  expect_difference(fracture_mesh(mesh, before_hits(p, 2)), after, *next->fractured.delta);
}

TEST(Delta, WithLimitsOfSizeAndARegionThatStays) {
  const Mesh mesh = torus(32, 16);
  const auto expect_local = [&](const char* what, const auto& change) {
    SCOPED_TRACE(what);
    FractureParameters p = hits_on(mesh, 40, 0.2);
    change(p);
    EXPECT_EQ(expect_hits(mesh, p), 3);
  };
  expect_local("limits of size", [](FractureParameters& p) { p.size.min_fraction = 0.02; });
  expect_local("a budget of triangles", [](FractureParameters& p) { p.size.max_triangles = 1'000'000; });
  expect_local("splitting", [](FractureParameters& p) { p.max_volume = 0.05; });
  expect_local("a region that stays", [](FractureParameters& p) {
    p.keep = Region{.center = {1, 0, 0}, .radius = 0.3};
  });
}

// A stored answer does not know the hits that follow, so it must not depend on them.
TEST(Delta, WhereSplittingRunsOutOfSites) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = hits_on(mesh, 10, 0.2);
  p.max_volume = volume_of(mesh) / 1000;
  p.most_sites = 60;
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(Delta, StoredAnswersHaveTheSameLimitOfSites) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = hits_on(mesh, 40, 0.2);  // with three hits of 12 sites
  p.most_sites = 40 + 2 * 12;
  Execution execution;
  StageTimings timings;
  const Solid solid = solid_of(mesh);
  const auto two = fracture_and_keep(solid, before_hits(p, 1), execution, timings);
  ASSERT_TRUE(two) << two.error().detail;
  const auto three = fracture_delta(solid, two->base, p, {1}, execution, timings);
  ASSERT_FALSE(three) << "the same request from scratch is refused";
  EXPECT_EQ(three.error().code, ErrorCode::kTooComplex);
  EXPECT_EQ(three.error().pointer, "local_sites");
}

// Without hits, the pattern breaks the solid; the first hit that leaves the rest whole does not continue that.
TEST(Delta, TheFirstHitThatLeavesTheRestWholeStartsFromScratch) {
  const Mesh mesh = torus(32, 16);
  FractureParameters whole = hits_on(mesh, 40, 0.2);
  whole.rest = LocalRest::kWhole;
  EXPECT_EQ(expect_hits(mesh, whole), 2);
}

TEST(Delta, WithLevelsAndAnchors) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = hits_on(mesh, 60, 0.15);
  p.levels = {4, 12};
  p.anchors.points = {{1, 0, 0}};
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(Delta, WhatChangedAloneIsAnchoredAsInTheWhole) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p = hits_on(mesh, 60, 0.15);
  p.anchors.planes.push_back({{1, 0, 0}, 0.3});  // holds three quarters of the ring
  EXPECT_EQ(expect_hits(mesh, p), 3);
  // The plane holds nothing. The whole warns about it, but a part need not.
  p.anchors.planes[0].offset = -100;
  EXPECT_EQ(expect_hits(mesh, p), 3);
}

TEST(Delta, OnlyPartOfTheFragmentsIsInTheAnswer) {
  const Mesh mesh = sphere_with(20000);
  FractureParameters p = hits_on(mesh, 300, 0.1);
  p.hits.resize(1);
  Execution execution;
  StageTimings timings;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(mesh), {}, execution);
  ASSERT_TRUE(solid);
  const auto base = fracture_and_keep(*solid, before_hits(p, 1), execution, timings);
  ASSERT_TRUE(base);
  auto next = fracture_delta(*solid, base->base, p, {1}, execution, timings);
  ASSERT_TRUE(next);
  const FragmentSet& set = next->fractured.set;
  const Delta& delta = next->fractured.delta.value();
  EXPECT_GT(set.fragments.size(), 300u);
  EXPECT_GE(delta.added.size(), 8u);
  keep_changed(next->fractured);
  EXPECT_LT(set.fragments.size(), 100u);
}

class DeltaOfMesh : public OnClosedMesh {};

TEST_P(DeltaOfMesh, EqualsTheWholeFracture) {
  FractureParameters p = hits_on(mesh, sized(20u, 60u), 0.15);
  p.hits.resize(sized(1u, 2u));
  expect_hits(mesh, p);
}

INSTANTIATE_TEST_SUITE_P(Dev, DeltaOfMesh, every_closed_mesh(), name_of_mesh);

TEST(Delta, OfFragmentsThatCarrySheetsIsThatOfTheWholeFracture) {
  const Mesh mesh =
      joined({cube(4), translated(open_quad(), {-0.5, -0.5, 0.6}), translated(open_quad(), {0, 0, 0.1})});
  EXPECT_GT(expect_hits(mesh, hits_on(mesh, 40, 0.2)), 0) << "such hits are local";
  FractureParameters stretched = hits_on(mesh, 40, 0.2);
  stretched.anisotropy.stretch = 2;
  expect_hits(mesh, stretched, 2);
}

TEST(Delta, ListsAFragmentIfOnlyItsSheetChanges) {
  const Mesh mesh = joined({cube(), translated(open_quad(), {-0.5, -0.5, 0.6})});
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.25, 0, 0}, {0.25, 0, 0}}};
  StageTimings timings;
  const Expected<KeptAnswer> kept = fracture_and_keep(solid_of(mesh), p, {}, timings);
  ASSERT_TRUE(kept);
  const FracturedSolid& was = kept->fractured;
  ASSERT_TRUE(was.set.fragments.at(0).sheet && was.set.fragments.at(1).sheet);
  const Delta none = difference(kept->base, was);
  EXPECT_TRUE(none.added.empty() && none.changed.empty() && none.gone.empty());
  FracturedSolid moved = was, without = was;
  Fragment sheet = *was.set.fragments[0].sheet;
  sheet.positions[0].x += 0.125f;
  moved.set.fragments[0].sheet = std::make_shared<const Fragment>(std::move(sheet));
  without.set.fragments[1].sheet = nullptr;
  EXPECT_EQ(difference(kept->base, moved).changed, (std::vector<std::uint64_t>{was.set.fragments[0].id}));
  EXPECT_EQ(difference(kept->base, without).changed, (std::vector<std::uint64_t>{was.set.fragments[1].id}));
}

TEST(Delta, OnlyChangedFragmentsBringTheirSheets) {
  const Mesh mesh = joined({cube(4), translated(open_quad(), {-0.5, -0.5, 0.6})});
  FractureParameters p = hits_on(mesh, 40, 0.1);
  p.hits.resize(1);
  const Solid solid = solid_of(mesh);
  StageTimings timings;
  const Expected<KeptAnswer> before = fracture_and_keep(solid, before_hits(p, 1), {}, timings);
  ASSERT_TRUE(before);
  const Expected<KeptAnswer> only = fracture_delta(solid, before->base, p, {1, true}, {}, timings),
                             all = fracture_delta(solid, before->base, p, {1, false}, {}, timings);
  ASSERT_TRUE(only && all);
  EXPECT_TRUE(only->local);
  EXPECT_EQ(only->fractured.delta->changed, all->fractured.delta->changed);
  EXPECT_EQ(only->fractured.delta->added, all->fractured.delta->added);
  EXPECT_LT(only->fractured.set.fragments.size(), all->fractured.set.fragments.size());
  for (const Fragment& f : only->fractured.set.fragments)
    for (const Fragment& g : all->fractured.set.fragments)
      if (f.id == g.id) {
        EXPECT_TRUE(same_sheet(f.sheet.get(), g.sheet.get()));
      }
  EXPECT_EQ(only->fractured.set.certificate.sheet_area_out, all->fractured.set.certificate.sheet_area_out);
}

TEST(Delta, AHitCutsTheSheetsOfTheFragmentsThatItCuts) {
  // The square, 1 m x 1 m, lies 0.02 m above the cube, and the hit is below the middle of the cube's upper side. At
  // 0.1 m, a guard would be nearer than any site of the hit, because sites lie in the cube.
  const Mesh mesh = joined({cube(4), translated(open_quad(), {-0.5, -0.5, 0.52})});
  const Solid solid = solid_of(mesh);
  ASSERT_TRUE(solid.sheets);
  FractureParameters p = hits_on(mesh, 40, 0.1);
  p.hits = {{{0, 0, 0.45}, 0.2, 30}};
  StageTimings timings;
  const Expected<KeptAnswer> before = fracture_and_keep(solid, before_hits(p, 1), {}, timings);
  ASSERT_TRUE(before);
  const Expected<KeptAnswer> after = fracture_delta(solid, before->base, p, {1, false}, {}, timings);
  ASSERT_TRUE(after) << after.error().detail;
  const FragmentSet& was = before->fractured.set;
  const FragmentSet& is = after->fractured.set;
  const auto carriers = [](const FragmentSet& set) {
    return std::count_if(set.fragments.begin(), set.fragments.end(),
                         [](const Fragment& f) { return f.sheet != nullptr; });
  };
  EXPECT_GT(carriers(is), carriers(was));
  EXPECT_NEAR(is.certificate.sheet_area_in, solid.sheets->area, 1e-9);
  EXPECT_NEAR(is.certificate.sheet_area_out, solid.sheets->area, 1e-6);
  double area = 0;
  for (const Fragment& f : is.fragments) {
    if (!f.sheet) continue;
    for (std::size_t k = 0; k < f.sheet->indices.size(); k += 3) {
      const auto at = [&](std::size_t n) { return to_double(f.sheet->positions[f.sheet->indices[k + n]]); };
      area += 0.5 * length(cross(at(1) - at(0), at(2) - at(0)));
    }
  }
  EXPECT_NEAR(area, solid.sheets->area, 1e-5);
  const std::vector<std::uint64_t>& changed = after->fractured.delta->changed;
  for (const Fragment& f : is.fragments)
    for (const Fragment& g : was.fragments)
      if (f.id == g.id && std::find(changed.begin(), changed.end(), f.id) == changed.end()) {
        EXPECT_EQ(f.sheet, g.sheet) << "the sheets of a fragment that is not cut are the same object";
      }
}

}  // namespace
}  // namespace fracture::test
