// The radius of a hit bounds what is cut. All distances are measured on the fragments of the answer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "common/contacts/contacts.hpp"
#include "common/hits/delta.hpp"
#include "common/materials/materials.hpp"
#include "tests/hits/delta_checks.hpp"
#include "tests/property/changed_surface.hpp"
#include "tests/property/judge.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// The bound that the documents state, in radii.
constexpr double kStatedReach = 1.25;

Vec3d vertex_of(const Fragment& f, std::uint32_t v) { return to_double(f.positions[v]) + f.pivot; }

std::map<std::uint64_t, const Fragment*> fragments_by_id(const FragmentSet& set) {
  std::map<std::uint64_t, const Fragment*> all;
  for (const Fragment& f : set.fragments) all.emplace(f.id, &f);
  return all;
}

/// Checks an answer to one hit against the answer before it.
void expect_bounded(const Mesh& mesh, const FractureParameters& with_hit) {
  const LocalImpact& hit = with_hit.hits.at(0);
  FractureParameters with = with_hit;
  with.pivot = Pivot::kSource;
  FractureParameters without = with;
  without.hits.clear();
  if (with_hit.rest == LocalRest::kWhole) {
    without.pattern = PointsPattern{{box_of(mesh).center()}};
    without.aggregation = {};
    without.anisotropy = {};
  }
  const Fractured before = fracture_mesh(mesh, without), after = fracture_mesh(mesh, with);
  expect_closed(after.set);
  expect_partition(after.set, volume_of(mesh), area_of(mesh));
  EXPECT_EQ(after.set.certificate.unmirrored_caps, 0u);
  EXPECT_GT(after.set.fragments.size(), before.set.fragments.size()) << "nothing broke";
  EXPECT_LE(farthest_new_vertex(before.set, after.set, hit.point, true), kStatedReach * hit.radius);
  if (!(with.roughness.amplitude > 0)) {  // otherwise, cuts inside move by up to the amplitude
    EXPECT_LE(farthest_new_vertex(before.set, after.set, hit.point, false), kStatedReach * hit.radius);
  }
  const auto is = fragments_by_id(after.set);
  for (const Fragment& f : before.set.fragments) {
    const auto at = is.find(f.id);
    if (at == is.end()) {
      // Nothing of it is left, so all of it was near.
      for (std::uint32_t v = 0; v < f.positions.size(); ++v)
        EXPECT_LE(length(vertex_of(f, v) - hit.point), kStatedReach * hit.radius);
      continue;
    }
    Box box;
    for (std::uint32_t v = 0; v < f.positions.size(); ++v) box.add(vertex_of(f, v));
    Vec3d outside;
    for (int a = 0; a < 3; ++a)
      outside[a] = std::max({box.min[a] - hit.point[a], hit.point[a] - box.max[a], 0.0});
    if (length(outside) <= kStatedReach * hit.radius) continue;
    // Out of reach: the same bits.
    EXPECT_EQ(at->second->positions, f.positions);
    EXPECT_EQ(at->second->indices, f.indices);
    EXPECT_EQ(at->second->pivot, f.pivot);
    EXPECT_EQ(at->second->mass.volume, f.mass.volume);
  }
}

Mesh unit_cube() { return box({-0.5, 0, -0.5}, {0.5, 1, 0.5}, 4); }

TEST(ReachOfHits, OfACube) {
  for (const std::uint32_t sites : {5u, 50u})
    for (const LocalRest rest : {LocalRest::kWhole, LocalRest::kFractured})
      for (const double rough : {0.0, 0.03}) {
        SCOPED_TRACE(sites);
        SCOPED_TRACE(rough);
        SCOPED_TRACE(rest == LocalRest::kWhole ? "whole" : "fractured");
        FractureParameters p;
        p.sites = 30;
        p.rest = rest;
        p.roughness.amplitude = rough;
        p.hits = {{{0, 1, 0}, 0.1, sites}};
        expect_bounded(unit_cube(), p);
      }
}

TEST(ReachOfHits, OfEveryMaterial) {
  std::size_t turn = 0;
  for (const MaterialPreset& preset : material_presets()) {
    if (!has_turn(turn++, 0, 3)) continue;
    SCOPED_TRACE(preset.name);
    FractureParameters p;
    p.sites = 25;
    p.rest = LocalRest::kFractured;
    p.pattern = preset.pattern;
    p.lloyd = preset.lloyd;
    p.anisotropy = {.stretch = preset.stretch, .grain = preset.grain};
    p.roughness = preset.roughness;
    p.aggregation = preset.aggregation;
    p.size.min_of_mean = kLeastOfMean;
    p.hits = {{{0.1, 1, 0.05}, 0.15, 20}};
    expect_bounded(unit_cube(), p);
  }
}

TEST(ReachOfHits, OfClosedShapes) {
  std::size_t turn = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(turn++, 1, 3)) continue;
    SCOPED_TRACE(shape.name);
    FractureParameters p;
    p.sites = 40;
    p.rest = LocalRest::kFractured;
    const Box box = box_of(shape.mesh);
    const Vec3d at = to_double(shape.mesh.positions.at(shape.mesh.positions.size() / 3));
    p.hits = {{at, 0.15 * box.longest_side(), 20}};
    const Fractured after = fracture_mesh(shape.mesh, p);
    expect_closed(after.set);
    expect_partition(after.set, volume_of(shape.mesh), area_of(shape.mesh));
  }
}

// The longest half-axis of the ellipsoid is the radius.
TEST(ReachOfHits, AlongTheGrainOfWood) {
  const Mesh beam = box({-1, -0.2, -0.2}, {1, 0.2, 0.2}, 6);
  for (const double stretch : {0.25, 3.0, 8.0}) {
    SCOPED_TRACE(stretch);
    FractureParameters p;
    p.sites = 40;
    p.rest = LocalRest::kFractured;
    p.anisotropy = {.stretch = stretch};
    p.hits = {{{0.3, 0.2, 0}, 0.3, 25}};
    expect_bounded(beam, p);
  }
}

// A house: walls, beams that touch them, and a roof that is far away from the hit.
TEST(ReachOfHits, PartsThatTheBallDoesNotTouchStayWhole) {
  std::vector<Mesh> parts;
  for (int k = 0; k < 6; ++k)
    parts.push_back(box({k * 1.0, 0, 0}, {k * 1.0 + 1, 2, 0.2}));  // walls, side by side
  for (int k = 0; k < 6; ++k) parts.push_back(box({k * 1.0 + 0.4, 2, -0.1}, {k * 1.0 + 0.6, 2.2, 3}));
  parts.push_back(box({0, 2.2, -0.1}, {6, 2.3, 3}));
  const Mesh house = joined(parts);
  Solid solid = *make_solid(std::make_shared<Mesh>(house), {}, {});
  keep_contacts(solid, {}, {});
  FractureParameters p;
  p.rest = LocalRest::kWhole;
  p.hulls = Hulls::kConvex;
  p.hits = {{{2.5, 1, 0.2}, 0.3, 30}};
  const Fractured after = fracture_solid(solid, p);
  expect_closed(after.set);
  std::map<std::uint32_t, std::size_t> pieces;
  for (const Fragment& f : after.set.fragments) ++pieces[f.part];
  ASSERT_EQ(pieces.size(), 13u);
  for (const auto& [part, count] : pieces) {
    if (part == 2)
      EXPECT_GT(count, 10u);
    else
      EXPECT_EQ(count, 1u) << part;
  }
  double volume = 0;
  for (const Fragment& f : after.set.fragments) volume += f.mass.volume;
  // Coordinates are floats below 8 m, so each is off by at most 2^-22 m. The volume changes by at most the area times
  // the way of a corner.
  EXPECT_NEAR(volume, 6 * 0.4 + 6 * 0.2 * 0.2 * 3.1 + 6 * 0.1 * 3.1, std::sqrt(3) * 0x1p-22 * area_of(house));
}

TEST(ReachOfHits, FragmentsOfSeveralPartsAreCut) {
  std::vector<Mesh> parts{box({-2, 0, -0.3}, {2, 0.3, 0.3}, 2), box({-1.7, -2, -0.1}, {-1.5, 0.1, 0.1}, 2)};
  for (int k = 0; k < 8; ++k) parts.push_back(box({-2 + k * 0.5, 0.3, -0.3}, {-1.5 + k * 0.5, 0.7, 0.3}));
  const Mesh mesh = joined(parts);
  Solid solid = *make_solid(std::make_shared<Mesh>(mesh), {}, {});
  keep_contacts(solid, {}, {});
  for (const double rough : {0.0, 0.02}) {
    SCOPED_TRACE(rough);
    FractureParameters p;
    p.sites = 6;
    p.rest = LocalRest::kFractured;
    p.roughness.amplitude = rough;
    p.size.fragments = 4;
    p.hulls = Hulls::kConvex;
    const Fractured before = fracture_solid(solid, p);
    ASSERT_TRUE(std::any_of(before.set.fragments.begin(), before.set.fragments.end(), [](const Fragment& f) {
      return !f.part_cells.empty();
    })) << "nothing is tested here";
    p.hits = {{{-1.6, 0.1, 0.1}, 0.3, 20}, {{0, 0.3, 0.3}, 0.25, 20}};
    const Fractured after = fracture_solid(solid, p);
    expect_closed(after.set);
    EXPECT_GT(after.set.fragments.size(), before.set.fragments.size() + 10);
    double volume = 0;
    for (const Fragment& f : after.set.fragments) volume += f.mass.volume;
    EXPECT_NEAR(volume, before.set.certificate.volume_in, 1e-6);
    EXPECT_EQ(after.set.certificate.unmirrored_caps, 0u);
  }
}

// The shape of a bond's two sides changes, but not the area that holds them together.
TEST(ReachOfHits, BondsAlongEarlierCutsAreDivided) {
  const Mesh cube = unit_cube();
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.25, 0.5, 0}, {0.25, 0.5, 0}}};
  p.rest = LocalRest::kFractured;
  p.hits = {{{0, 1, 0}, 0.2, 20}};
  const Fractured after = fracture_mesh(cube, p);
  double across = 0;  // bonds between the halves lie in the plane x = 0
  std::size_t count = 0;
  for (const Bond& bond : after.set.bonds) {
    if (std::fabs(bond.centroid.x) > 1e-9 || std::fabs(bond.normal.x) < 0.999999) continue;
    across += bond.area;
    ++count;
  }
  EXPECT_NEAR(across, 1, 1e-6);
  EXPECT_GT(count, 3u);
}

// The only cell reaches to half the distance of the guards, which are far outside the cube.
TEST(ReachOfHits, AHitThatCutsNothingSaysSo) {
  FractureParameters p;
  p.rest = LocalRest::kWhole;
  p.hits = {{{0, 1, 0}, 20, 1}};
  const Fractured made = fracture_mesh(unit_cube(), p);
  EXPECT_EQ(made.set.fragments.size(), 1u);
  EXPECT_TRUE(warns(made.report, "Hit 1 cuts nothing"));
  p.hits = {{{0, 1, 0}, 0.2, 5}};
  EXPECT_FALSE(warns(fracture_mesh(unit_cube(), p).report, "cuts nothing"));
}

// A beam that the ball misses by a hundredth of the radius, next to the beam that is hit.
TEST(ReachOfHits, PartsBetweenTheBallAndTheReachStayWhole) {
  const double radius = 0.2;
  const Mesh mesh =
      joined({box({-0.5, -1, -1}, {0.15, 0, 1}, 4), box({1.01 * radius, -1, -1}, {0.5, 0, 1}, 4)});
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    FractureParameters p;
    p.rest = LocalRest::kWhole;
    p.seed = seed;
    p.hits = {{{0, 0, 0}, radius, 12}};
    const Fractured made = fracture_mesh(mesh, p);
    std::map<std::uint32_t, std::size_t> pieces;
    for (const Fragment& f : made.set.fragments) ++pieces[f.part];
    EXPECT_GT(pieces[0], 5u);
    EXPECT_EQ(pieces[1], 1u);
  }
}

// So a client that has an earlier answer and the changes knows the order of the whole answer.
TEST(ReachOfHits, FragmentsAreInTheOrderOfTheirSitesPartsAndIds) {
  FractureParameters p;
  p.sites = 10;
  for (const LocalRest rest : {LocalRest::kWhole, LocalRest::kFractured}) {
    p.rest = rest;
    p.hits = {{{0, 1, 0}, 0.2, 12}, {{0.1, 1, 0}, 0.15, 12}};
    const FragmentSet set = fracture_mesh(unit_cube(), p).set;
    const auto key = [](const Fragment& f) { return std::tuple(f.sites.front(), f.part, f.id); };
    ASSERT_GT(set.fragments.size(), 20u);
    for (std::size_t k = 1; k < set.fragments.size(); ++k)
      EXPECT_LT(key(set.fragments[k - 1]), key(set.fragments[k])) << k;
    for (const Bond& bond : set.bonds) EXPECT_LT(bond.a, bond.b);
  }
}

TEST(ReachOfHits, ALaterHitCutsWhatEarlierOnesMade) {
  const Mesh cube = with_traced_triangles(unit_cube());
  FractureParameters p;
  p.sites = 10;
  p.rest = LocalRest::kFractured;
  p.hulls = Hulls::kConvex;
  std::size_t last = fracture_mesh(cube, p).set.fragments.size();
  for (int k = 0; k < 4; ++k) {
    p.hits.push_back({{0.05 * k, 1, 0.02 * k}, 0.15, 12});
    const Fractured made = fracture_mesh(cube, p);
    expect_closed(made.set);
    expect_partition(made.set, volume_of(cube), area_of(cube));
    expect_outside_untouched(made.set, cube);
    EXPECT_GT(made.set.fragments.size(), last + 5);
    std::set<std::uint64_t> ids;
    for (const Fragment& f : made.set.fragments) ids.insert(f.id);
    EXPECT_EQ(ids.size(), made.set.fragments.size());
    last = made.set.fragments.size();
  }
}

TEST(ReachOfHits, ThreadsDoNotChangeABit) {
  const Mesh mesh = sphere_with_seams(24, 48);
  FractureParameters p = hits_on(mesh, 60, 0.15);
  p.roughness = {0.03, 5, 2};
  p.aggregation = {3, 1};
  expect_same(fracture_mesh(mesh, p, 1), fracture_mesh(mesh, p, 4));
}

TEST(ReachOfHits, AKeptRegionStaysWhole) {
  const Mesh cube = unit_cube();
  FractureParameters p;
  p.sites = 12;
  p.rest = LocalRest::kFractured;
  p.keep = Region{.center = {0, 1, 0}, .radius = 0.05};
  p.hits = {{{0, 1, 0}, 0.2, 40}};
  const Fractured made = fracture_mesh(cube, p);
  std::set<std::uint64_t> owners;  // of surface vertices in the region
  for (const Fragment& f : made.set.fragments)
    for (std::uint32_t v = 0; v < f.positions.size(); ++v)
      if (length(vertex_of(f, v) - Vec3d{0, 1, 0}) < 0.045) owners.insert(f.id);
  EXPECT_LE(owners.size(), 1u);
}

// The reach follows from the guards: an upper bound for the angle, and the inequality of local_impact.hpp.
TEST(ReachOfHits, FollowsFromTheGuards) {
  const std::span<const Vec3d> guards = guard_directions();
  ASSERT_EQ(guards.size(), 42u);
  double least = 1;
  constexpr int kSteps = 700;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (const double side : {-1.0, 1.0}) {  // all points of a cube's surface up to symmetry of the guards
        const Vec3d p{side, -1 + 2.0 * i / kSteps, -1 + 2.0 * j / kSteps};
        double best = -1;
        for (const Vec3d& g : guards) best = std::max(best, dot(g, p) / length(p));
        least = std::min(least, best);
      }
  EXPECT_GE(least, kGuardCosine);
  const double s = kSitesWithin + 0.01, x = kReach, g = kGuardsAt;  // 0.01: sites are rounded
  EXPECT_LT(x * x + g * g - 2 * x * g * kGuardCosine, (x - s) * (x - s));
  EXPECT_LT(kReach, kStatedReach);
}

}  // namespace
}  // namespace fracture::test
