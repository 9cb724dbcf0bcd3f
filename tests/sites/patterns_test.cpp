// The patterns as lists of sites, and the options they use.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "common/sites/arithmetic.hpp"
#include "common/sites/column_sampler.hpp"
#include "common/sites/pattern.hpp"
#include "common/sites/sites.hpp"
#include "common/solid/image.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"
#include "tests/support/surface_mesh.hpp"

namespace fracture::test {
namespace {

SitePlan plan_of(const Solid& solid, SitePattern pattern, std::uint32_t sites = 50, std::uint64_t seed = 1) {
  SiteParameters p;
  p.sites = sites;
  p.seed = seed;
  p.pattern = std::move(pattern);
  return *plan_sites(solid, p, {});
}

TEST(Arithmetic, PowerAgreesWithTheLibrary) {
  for (const double base : {0.0, 1e-9, 0.1, 0.5, 0.999, 1.0})
    for (const double exponent : {1.0 / 3, 0.5, 1.0, 1.7, 2.0, 9.99})
      EXPECT_NEAR(sites_detail::power(base, exponent), std::pow(base, exponent), 1e-11)
          << base << "^" << exponent;
}

TEST(Arithmetic, LogarithmAgreesWithTheLibrary) {
  for (const double x : {1e-300, 1e-9, 0.1, 0.5, 0.70710678, 0.7071068, 0.999999, 1.0, 1.5, 3.0, 1e10})
    EXPECT_NEAR(sites_detail::logarithm(x), std::log(x), 1e-15 * (1 + std::fabs(std::log(x)))) << x;
}

TEST(Arithmetic, UnitAtAgreesWithTheLibrary) {
  for (int k = -400; k <= 400; ++k) {
    const double turns = k / 173.0, angle = 2 * M_PI * turns;
    EXPECT_NEAR(sites_detail::unit_at(turns).x, std::cos(angle), 1e-13);
    EXPECT_NEAR(sites_detail::unit_at(turns).y, std::sin(angle), 1e-13);
  }
}

TEST(Arithmetic, AcrossIsARightHandedFrame) {
  for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, -3, 0}, Vec3d{1e-9, 2e-9, -1e-9}, Vec3d{1e6, 1, -1e6}}) {
    const auto [u, v] = sites_detail::across(axis);
    EXPECT_NEAR(length(u), 1, 1e-14);
    EXPECT_NEAR(length(v), 1, 1e-14);
    EXPECT_NEAR(dot(u, v), 0, 1e-14);
    EXPECT_NEAR(dot(cross(u, v), axis) / length(axis), 1, 1e-14);
  }
}

TEST(ColumnSampler, TellsInsideAsTheWindingNumberDoes) {
  for (const NamedMesh& shape : closed_shapes()) {
    SCOPED_TRACE(shape.name);
    const Solid solid = solid_of(shape.mesh);
    const Execution execution;
    sites_detail::ColumnSampler sampler(solid, 1, execution);
    Random random(7);
    std::vector<Vec3d> points;
    for (int k = 0; k < 200; ++k) {
      Vec3d p;
      for (int a = 0; a < 3; ++a)
        p[a] = solid.box.min[a] + (1.2 * random.uniform() - 0.1) * (solid.box.max[a] - solid.box.min[a]);
      points.push_back(p);
    }
    const std::vector<bool> inside = sampler.inside(points);
    int wrong = 0;
    for (std::size_t k = 0; k < points.size(); ++k)
      wrong += inside[k] != (winding_number(shape.mesh, points[k]) > 0.5);
    EXPECT_EQ(wrong, 0);
  }
}

TEST(Patterns, AreFunctionsOfTheSeed) {
  const Solid solid = solid_of(torus(24, 12));
  for (const SitePattern& pattern : std::vector<SitePattern>{
           UniformPattern{}, ImpactPattern{}, RadialPattern{}, GridPattern{.jitter = 0.5},
           BrickPattern{.jitter = 0.5}, SlicePattern{}, ClusteredPattern{}}) {
    SCOPED_TRACE(kPatternTraits[pattern.index()].name);
    EXPECT_EQ(plan_of(solid, pattern, 50, 3).points, plan_of(solid, pattern, 50, 3).points);
    EXPECT_NE(plan_of(solid, pattern, 50, 3).points, plan_of(solid, pattern, 50, 4).points);
  }
}

TEST(Patterns, GeneratedSitesLieOnTheLatticeAndGivenOnesAreLeftAlone) {
  const Solid solid = solid_of(cube());
  const SiteLattice lattice = site_lattice(solid.box);
  for (const SitePattern& pattern :
       std::vector<SitePattern>{ImpactPattern{}, RadialPattern{}, ClusteredPattern{}})
    for (const Vec3d& p : plan_of(solid, pattern).points) EXPECT_EQ(lattice.snap(p), p);
  const std::vector<Vec3d> own{{0.1, 0.2, 0.3}, {1.0 / 3, -0.1, 7}};
  EXPECT_EQ(plan_of(solid, PointsPattern{own}).points, own);
}

TEST(ImpactPattern, AllOfASmallRadiusIsFilledWithTheAskedDensity) {
  const Solid solid = solid_of(cube(2));
  for (const double exponent : {0.0, 1.0, 2.0, 2.5}) {
    SCOPED_TRACE(exponent);
    const double radius = 0.01;
    const SitePlan plan = plan_of(
        solid, ImpactPattern{.impacts = {{0.1, 0, 0}}, .radius = radius, .exponent = exponent, .share = 1},
        4000);
    ASSERT_EQ(plan.points.size(), 4000u);
    EXPECT_TRUE(plan.remarks.empty());
    // The share (r / radius)^(3 - exponent) lies within a distance r.
    for (const double part : {0.25, 0.5, 0.75}) {
      const auto near = std::count_if(plan.points.begin(), plan.points.end(), [&](const Vec3d& p) {
        return length(p - Vec3d{0.1, 0, 0}) <= part * radius;
      });
      EXPECT_NEAR(static_cast<double>(near) / 4000, std::pow(part, 3 - exponent), 0.03);
    }
  }
}

TEST(ImpactPattern, AnImpactFarOutsideLeavesUniformSitesAndSaysSo) {
  const Solid solid = solid_of(cube(2));
  const SitePlan plan = plan_of(solid, ImpactPattern{.impacts = {{50, 0, 0}}, .radius = 0.1});
  EXPECT_EQ(plan.points.size(), 50u);
  const auto& [warnings, notes] = plan.remarks;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(notes.empty());
  EXPECT_NE(warnings[0].find("no room for sites within 0.1 m of the impacts"), std::string::npos)
      << warnings[0];
  EXPECT_NE(warnings[0].find("Move 'impacts' onto the mesh"), std::string::npos) << warnings[0];
}

TEST(ImpactPattern, AnEmptyMiddleThatNobodyHitIsANote) {
  // A shell of 2 m around an empty room of 1.8 m.
  const Solid solid =
      solid_of(joined({scaled(cube(), {2, 2, 2}), reversed(scaled(cube(), {1.8f, 1.8f, 1.8f}))}));
  const SitePlan plan = plan_of(solid, ImpactPattern{.radius = 0.5});
  EXPECT_TRUE(plan.remarks.warnings.empty());
  ASSERT_EQ(plan.remarks.notes.size(), 1u);
  EXPECT_TRUE(plan.remarks.notes[0].starts_with("No impact point is set ('impacts')"))
      << plan.remarks.notes[0];
  EXPECT_NE(plan.remarks.notes[0].find("for 40 of 40 sites within 0.5 m of this centre"), std::string::npos);
}

TEST(GridPattern, CountsAndCellsAreAsAsked) {
  const Solid solid = solid_of(box({0, 0, 0}, {2, 1, 1}));
  EXPECT_EQ(plan_of(solid, GridPattern{.cell = Vec3d{0.5, 0.25, 1}}).points.size(), 4u * 4 * 1);
  EXPECT_EQ(plan_of(solid, GridPattern{}, 16).points.size(), 16u);
  const SitePlan bricks = plan_of(solid, BrickPattern{.cell = Vec3d{0.5, 0.25, 1}});
  EXPECT_EQ(bricks.points.size(), 8u * 4 * 1);
  EXPECT_EQ(bricks.groups.size(), bricks.points.size());
}

TEST(Patterns, TooManySitesAreATypedError) {
  const Solid solid = solid_of(cube());
  const std::pair<SitePattern, const char*> cases[] = {
      {GridPattern{.cell = Vec3d{1e-4, 1e-4, 1e-4}}, "cell"},
      {BrickPattern{.cell = Vec3d{1e-6, 1e-6, 1e-6}}, "cell"},
      {SlicePattern{.spacing = 1e-6}, "spacing"},
      {RadialPattern{.spokes = 720, .rings = 1000}, "rings"},
      {SlicePattern{.normals = {{1, 0, 0}, {0, 1, 0}}, .spacing = 1e-6}, "spacing"}};
  for (const auto& [pattern, parameter] : cases) {
    SiteParameters p;
    p.pattern = pattern;
    const Expected<SitePlan> plan = plan_sites(solid, p, {});
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().code, ErrorCode::kTooComplex);
    EXPECT_EQ(plan.error().pointer, parameter);
    EXPECT_NE(plan.error().detail.find("the limit is 100,000 (server option --max-sites"), std::string::npos)
        << plan.error().detail;
  }
}

TEST(Patterns, MakeTheCellsOfAggregatesUpToTheirLimits) {
  const Solid solid = solid_of(cube());
  SiteParameters p;
  p.sites = 20;
  p.aggregation.cells = 7;
  EXPECT_EQ(plan_sites(solid, p, {})->points.size(), 140u);
  EXPECT_EQ(expected_sites(p, solid.box), 140);
  p.most_sites = 139;
  const Expected<SitePlan> refused = plan_sites(solid, p, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooComplex);
  p.most_sites = kMaxPatternSites;
  p.sites = kMaxPatternSites / 3;
  const Expected<SitePlan> fewer = plan_sites(solid, p, {});
  ASSERT_TRUE(fewer);
  EXPECT_EQ(fewer->points.size(), 3u * (kMaxPatternSites / 3));
  ASSERT_EQ(fewer->remarks.warnings.size(), 1u);
  EXPECT_NE(fewer->remarks.warnings[0].find("'cells_per_fragment' is 3"), std::string::npos);
  p.sites = 20;
  p.pattern = GridPattern{};
  EXPECT_EQ(cells_per_fragment(p), 1u);
}

TEST(Patterns, SlicesOfSeveralFamiliesCannotBeStretched) {
  SiteParameters p;
  p.pattern = SlicePattern{.normals = {{1, 0, 0}, {0, 1, 0}}};
  p.anisotropy.stretch = 2;
  const Expected<SitePlan> plan = plan_sites(solid_of(cube()), p, {});
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(plan.error().pointer, "stretch");
}

TEST(Anisotropy, TheMapCompressesAlongTheGrainAndMirrorsAreTurnedBack) {
  const Solid solid = solid_of(box({0, 0, 0}, {1, 3, 1}));
  SiteParameters p;
  p.anisotropy.stretch = 4;
  const CellMap map = plan_sites(solid, p, {})->map;
  ASSERT_TRUE(map);
  EXPECT_EQ(map.of_part(0).image({1, 4, 1}), (Vec3d{1, 1, 1})) << "the grain is the longest side";
  p.anisotropy = {.matrix = Matrix3{{Vec3d{-2, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}}};
  const CellMap mirrored = plan_sites(solid, p, {})->map;
  ASSERT_TRUE(mirrored);
  const double determinant = mirrored.of_part(0).matrix.determinant();
  EXPECT_GT(determinant, 0);
  EXPECT_NEAR(determinant, 0.5, 1e-12);
}

TEST(ImageOf, KeepsTheTopologyAndStatesTheImagesFigures) {
  const Mesh mesh = nested_spheres(3, 800);
  const Solid solid = solid_of(mesh);
  const Matrix3 map{{Vec3d{2, 0, 0}, Vec3d{0, 0.5, 0.1}, Vec3d{0, 0, 3}}};
  const Solid image = image_of(solid, map);
  EXPECT_EQ(image.triangles, solid.triangles);
  EXPECT_EQ(image.edge_vertices, solid.edge_vertices);
  ASSERT_EQ(image.positions.size(), solid.positions.size());
  const Mesh seen = surface_mesh(image);
  EXPECT_NEAR(image.report.volume, volume_of(seen), 1e-6 * image.report.volume);
  EXPECT_NEAR(image.report.area, area_of(seen), 1e-6 * image.report.area);
  EXPECT_EQ(image.box.min, box_of(seen).min);
  EXPECT_EQ(image.box.max, box_of(seen).max);
}

/// The mean distance from each site to the next one in the list.
double mean_step(const std::vector<Vec3d>& points) {
  double sum = 0;
  for (std::size_t k = 1; k < points.size(); ++k) sum += length(points[k] - points[k - 1]);
  return sum / static_cast<double>(points.size() - 1);
}

TEST(SiteOrder, NeighboursInTheListAreNeighboursInSpace) {
  const Solid solid = solid_of(sphere_with(2000));
  std::vector<Vec3d> points = plan_of(solid, UniformPattern{}, 5000).points;
  const double spacing = std::cbrt(solid.report.volume / 5000);
  EXPECT_LT(mean_step(points), 2 * spacing);
  EXPECT_GT(mean_step(plan_of(solid, PointsPattern{{{0.5, 0, 0}, {-0.5, 0, 0}, {0.4, 0, 0}}}).points), 0.8)
      << "what the caller gave stays in the caller's order";
}

TEST(SiteOrder, GroupsGoWithTheirSites) {
  const Solid solid = solid_of(box({0, 0, 0}, {4, 2, 1}));
  BrickPattern bricks;
  bricks.cell = Vec3d{1, 0.5, 0.5};
  const SitePlan plan = plan_of(solid, bricks);
  ASSERT_EQ(plan.groups.size(), plan.points.size());
  std::map<std::uint32_t, Box> of_group;
  for (std::size_t k = 0; k < plan.points.size(); ++k) of_group[plan.groups[k]].add(plan.points[k]);
  EXPECT_GE(of_group.size(), 30u);
  for (const auto& [group, box_of_brick] : of_group) {
    const Vec3d size = box_of_brick.size();
    EXPECT_LE(size.x, 1) << group;
    EXPECT_LE(size.y, 0.5) << group;
    EXPECT_LE(size.z, 0.5) << group;
  }
}

}  // namespace
}  // namespace fracture::test
