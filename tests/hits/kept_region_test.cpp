// Hits next to a region to keep: the region stays whole, and everything around it breaks. All distances are measured on the fragments
// of the answer.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "common/materials/materials.hpp"
#include "common/pipeline/local_impact.hpp"
#include "tests/property/judge.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

constexpr double kRounding = 1e-6;
const Vec3d kTop{0, 1, 0};

Mesh kept_cube() { return box({-0.5, 0, -0.5}, {0.5, 1, 0.5}, 4); }

/// All of the unit cube below `height`.
Region below(double height) { return {.shape = Region::Shape::kBox, .box = {{-1, -1, -1}, {1, height, 1}}}; }
Region ball() { return {.center = {0, 0.8, 0}, .radius = 0.15}; }

/// How far a point is inside the region, m; negative: outside.
double depth_in(const Region& region, const Vec3d& p) {
  if (region.shape == Region::Shape::kSphere) return region.radius - length(p - region.center);
  double depth = 1e9;
  for (int a = 0; a < 3; ++a) depth = std::min({depth, region.box.max[a] - p[a], p[a] - region.box.min[a]});
  return depth;
}

FractureParameters hit_near(const Region& region, LocalRest rest) {
  FractureParameters p;
  p.sites = 20;
  p.pivot = Pivot::kSource;
  p.rest = rest;
  p.keep = region;
  p.hits = {{kTop, 0.25, 30}};
  return p;
}

void take_material(const std::string& name, FractureParameters& p) {
  const MaterialPreset& preset = *find_material_preset(name);
  p.lloyd = preset.lloyd;
  p.anisotropy = {.stretch = preset.stretch, .grain = preset.grain};
  p.roughness = preset.roughness;
  p.aggregation = preset.aggregation;
  p.size.min_of_mean = kLeastOfMean;
}

const Fragment& largest(const FragmentSet& set) {
  return *std::max_element(
      set.fragments.begin(), set.fragments.end(),
      [](const Fragment& a, const Fragment& b) { return a.mass.volume < b.mass.volume; });
}

/// The greatest depth of a vertex of all fragments but the largest, which contains the region.
double deepest_of_others(const FragmentSet& set, const Region& region) {
  double deepest = -1e9;
  for (const Fragment& f : set.fragments) {
    if (&f == &largest(set)) continue;
    for (const Vec3f& v : f.positions) deepest = std::max(deepest, depth_in(region, to_double(v) + f.pivot));
  }
  return deepest;
}

void expect_sound(const Fractured& made, const Mesh& mesh) {
  expect_closed(made.set);
  expect_partition(made.set, made.solid.report.volume, made.solid.report.area);
  expect_outside_untouched(made.set, mesh);
  EXPECT_EQ(made.set.certificate.unmirrored_caps, 0u);
}

// Until algorithm 27, each cell that met the region belonged to it: 8 pieces of 30 sites came off above a box, and in wood none.
TEST(HitsAtAKeptRegion, BreakWhatIsOutside) {
  const Mesh mesh = with_traced_triangles(kept_cube());
  for (const Region& region : {below(0.9), ball()}) {
    const FractureParameters p = hit_near(region, LocalRest::kWhole);
    const Fractured made = fracture_mesh(mesh, p);
    expect_sound(made, mesh);
    EXPECT_GE(made.set.fragments.size(), 16u);
    const double deepest = deepest_of_others(made.set, region);
    EXPECT_LE(deepest, kRounding) << "a cut goes through the region";
    EXPECT_TRUE(has_note(made.report, "Hit 1 reaches into the region to keep"));
    EXPECT_FALSE(warns(made.report, "contains the whole mesh"));
    // The first hit's cells end 0.02 radii before a box.
    if (region.shape == Region::Shape::kBox) {
      EXPECT_NEAR(deepest, -0.02 * 0.25, 1e-4);
    }
  }
}

TEST(HitsAtAKeptRegion, BreakEveryMaterialUpToIt) {
  const Mesh mesh = with_traced_triangles(kept_cube());
  const Region region = below(0.96);
  for (const char* material : {"stone", "wood", "glass", "concrete"}) {
    SCOPED_TRACE(material);
    FractureParameters p = hit_near(region, LocalRest::kWhole);
    take_material(material, p);
    const Fractured made = fracture_mesh(mesh, p);
    expect_sound(made, mesh);
    EXPECT_GE(made.set.fragments.size(), 3u);
    EXPECT_LE(deepest_of_others(made.set, region), kRounding);
  }
}

// Sites in the region are replaced by others around it, but a hit never has more sites than it asks for.
TEST(HitsAtAKeptRegion, HaveAtMostTheirSites) {
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(kept_cube()), {}, {});
  ASSERT_TRUE(solid);
  for (const Region& region : {below(0.8), below(0.9), ball()}) {
    FractureParameters p = hit_near(region, LocalRest::kWhole);
    p.hits = std::vector<LocalImpact>(8, p.hits[0]);
    for (std::size_t k = 0; k < p.hits.size(); ++k) {
      Remarks remarks;
      const Expected<HitCells> cells = cells_of_hit(*solid, p, p.hits, k, p.keep, remarks, {});
      ASSERT_TRUE(cells);
      EXPECT_LE(cells->sites, p.hits[k].sites) << k;
      EXPECT_GE(cells->sites, 8u) << k;
    }
  }
}

// Each of the 200 sites has a companion in the rest, which does not get a hull for each of them.
TEST(HitsAtAKeptRegion, GiveTheRestFewHulls) {
  FractureParameters p = hit_near(below(0.9), LocalRest::kWhole);
  p.hulls = Hulls::kConvex;
  p.hits[0].sites = 200;
  const Fractured made = fracture_mesh(kept_cube(), p);
  const Fragment& rest = largest(made.set);
  const auto index = static_cast<std::size_t>(&rest - made.set.fragments.data());
  const FragmentHulls& hulls = made.hulls.of_fragment.at(index);
  EXPECT_LE(hulls.hulls.size(), guard_directions().size());
  EXPECT_GT(hulls.volume, 0.5 * rest.mass.volume);
}

TEST(HitsAtAKeptRegion, LeaveItsFragmentAsItIs) {
  const Mesh mesh = with_traced_triangles(kept_cube());
  const Region region = below(0.9);
  FractureParameters p = hit_near(region, LocalRest::kFractured);
  FractureParameters without = p;
  without.hits.clear();
  const Fractured before = fracture_mesh(mesh, without);
  const Fragment& kept = largest(before.set);
  EXPECT_NEAR(kept.mass.volume, 0.9, 1e-4);
  p.hits.push_back({{0.05, 1, 0.02}, 0.2, 20});
  const Fractured made = fracture_mesh(mesh, p);
  expect_sound(made, mesh);
  EXPECT_GE(made.set.fragments.size(), before.set.fragments.size() + 20);
  const Fragment& still = largest(made.set);
  EXPECT_EQ(still.id, kept.id);
  EXPECT_EQ(still.positions, kept.positions);
  EXPECT_EQ(still.indices, kept.indices);
  EXPECT_EQ(still.mass.volume, kept.mass.volume);
}

TEST(HitsAtAKeptRegion, SayThatAllIsKept) {
  FractureParameters p = hit_near(below(2), LocalRest::kWhole);
  const Fractured made = fracture_mesh(kept_cube(), p);
  EXPECT_EQ(made.set.fragments.size(), 1u);
  EXPECT_TRUE(warns(made.report, "everything it reaches is in the region to keep"));
}

TEST(HitsAtAKeptRegion, DoNotMentionARegionOutOfReach) {
  const FractureParameters p = hit_near(below(0.5), LocalRest::kWhole);
  const Fractured made = fracture_mesh(kept_cube(), p);
  EXPECT_GT(made.set.fragments.size(), 16u);
  EXPECT_FALSE(has_note(made.report, "region to keep"));
}

// LocalRest::kWhole has one point in the middle of the box, which may be empty. It is not one of the request.
TEST(HitsAtAKeptRegion, HollowSolidsGetNoWarningAboutPoints) {
  const Mesh hollow = joined({kept_cube(), reversed(box({-0.4, 0.1, -0.4}, {0.4, 0.9, 0.4}, 4))});
  FractureParameters p = hit_near(ball(), LocalRest::kWhole);
  p.keep.reset();
  EXPECT_FALSE(warns(fracture_mesh(hollow, p).report, "'points'"));
}

}  // namespace
}  // namespace fracture::test
