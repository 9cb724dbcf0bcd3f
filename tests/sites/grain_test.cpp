#include "common/sites/grain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>

#include "common/sites/pattern.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

constexpr Vec3d kUp{0, 1, 0};

Mesh turned(Mesh mesh, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  for (Vec3f& p : mesh.positions)
    p = {static_cast<float>(c * p.x - s * p.y), static_cast<float>(s * p.x + c * p.y), p.z};
  return mesh;
}

/// A top along x and z, and four legs along y.
Mesh table() {
  std::vector<Mesh> parts{box({0, 1, 0}, {3, 1.1, 1}, 2)};
  for (const double x : {0.1, 2.8})
    for (const double z : {0.1, 0.8}) parts.push_back(box({x, 0, z}, {x + 0.1, 0.99, z + 0.1}, 2));
  return joined(parts);
}

double along(const Vec3d& a, const Vec3d& b) { return std::fabs(dot(a, b)); }

TEST(Grain, RunsAlongTheLongestAxisOfABarHoweverItLies) {
  for (const double angle : {0.0, 0.3, 0.8, 1.5}) {
    const Grains grains =
        grains_of(solid_of(turned(box({2, 1, 0}, {5, 1.2, 0.3}), angle)), GrainOf::kPart, kUp, 8);
    ASSERT_EQ(grains.directions.size(), 1u);
    EXPECT_NEAR(along(grains.directions[0], {std::cos(angle), std::sin(angle), 0}), 1, 1e-6);
    EXPECT_NEAR(length(grains.directions[0]), 1, 1e-12);
  }
}

TEST(Grain, OfWhatIsNotLongIsThatOfTheWhole) {
  for (const Mesh& mesh : {cube(2), ico_sphere(2), thin_plate(0.01), torus(24, 12)})
    EXPECT_EQ(grains_of(solid_of(mesh), GrainOf::kPart, kUp, 8).directions, std::vector<Vec3d>{kUp});
}

TEST(Grain, LegsOfATableHaveAnotherOneThanItsTop) {
  const Solid solid = solid_of(table());
  ASSERT_EQ(solid.parts.size(), 5u);
  const Grains grains = grains_of(solid, GrainOf::kPart, {0, 0, 1}, 8);
  ASSERT_EQ(grains.directions.size(), 2u);
  for (std::size_t p = 0; p < 5; ++p) {
    const Vec3d size = solid.parts[p].box.size();
    EXPECT_NEAR(along(grains.directions[grains.of_part[p]], size.x > 1 ? Vec3d{1, 0, 0} : kUp), 1, 1e-9);
  }
  EXPECT_EQ(grains_of(solid, GrainOf::kNode, kUp, 8).directions.size(), 1u) << "all of one node";
}

TEST(Grain, PartsOfOneMaterialHaveOne) {
  Mesh mesh = table();
  // The top has material 0. The legs have material 1, except for one face of each that is painted like the
  // top.
  mesh.material.assign(mesh.triangles.size(), 1);
  const std::size_t each = mesh.triangles.size() / 5, face = each / 6;
  std::fill_n(mesh.material.begin(), each, 0);
  for (std::size_t leg = 1; leg < 5; ++leg)
    std::fill_n(mesh.material.begin() + static_cast<std::ptrdiff_t>(leg * each), face, 0);
  const Solid solid = solid_of(mesh);
  ASSERT_EQ(solid.parts.size(), 5u);
  const Grains two = grains_of(solid, GrainOf::kMaterial, {0, 0, 1}, 8);
  EXPECT_EQ(two.directions.size(), 2u);
  std::set<int> of_legs, of_top;
  for (std::size_t p = 0; p < 5; ++p)
    (solid.parts[p].box.size().x > 1 ? of_top : of_legs).insert(two.of_part[p]);
  ASSERT_EQ(of_top.size(), 1u);
  ASSERT_EQ(of_legs.size(), 1u);
  EXPECT_NEAR(along(two.directions[static_cast<std::size_t>(*of_top.begin())], {1, 0, 0}), 1, 1e-9);
  EXPECT_NE(*of_top.begin(), *of_legs.begin());

  mesh.material.assign(mesh.triangles.size(), 0);
  EXPECT_EQ(grains_of(solid_of(mesh), GrainOf::kMaterial, {0, 0, 1}, 8).directions.size(), 1u)
      << "of one material";
}

TEST(Grain, NoMoreDirectionsThanAreAskedFor) {
  std::vector<Mesh> fan;
  for (int k = 0; k < 12; ++k)
    fan.push_back(translated(turned(box({0, 0, 0}, {2.0 + 0.1 * k, 0.2, 0.2}), 0.26 * k), {0, 0, 1.0 * k}));
  const Solid solid = solid_of(joined(fan));
  EXPECT_EQ(grains_of(solid, GrainOf::kPart, kUp, 64).directions.size(), 12u);
  const Grains few = grains_of(solid, GrainOf::kPart, kUp, 4);
  ASSERT_EQ(few.directions.size(), 4u);
  EXPECT_NEAR(along(few.directions[0], {std::cos(0.26 * 11), std::sin(0.26 * 11), 0}), 1, 1e-6)
      << "the largest";
  EXPECT_EQ(std::set<int>(few.of_part.begin(), few.of_part.end()).size(), 4u);
}

TEST(CellMap, EachFrameIsFarFromTheOthersAndBackIsBack) {
  const Solid solid = solid_of(table());
  SiteParameters p;
  p.anisotropy = {.stretch = 5, .grain_of = GrainOf::kPart};
  const CellMap map = map_of_cells(solid, p, {}).value();
  ASSERT_EQ(map.frames().size(), 2u);
  const Solid image = image_of(solid, map);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t)
    for (const VertexId v : solid.triangles[t]) {
      const Vec3d at = to_double(image.positions[v]), from = to_double(solid.positions[v]);
      EXPECT_EQ(&map.at(at), &map.of_part(solid.part[t]));
      EXPECT_LT(length(map.at(at).place(at) - from), 1e-5);
    }
  // For any point of one part, all points of that part are closer than any point of the other part.
  double widest = 0, gap = HUGE_VAL;
  for (const Vec3f& a : image.positions)
    for (const Vec3f& b : image.positions) {
      const double far = length(to_double(a) - to_double(b));
      if (map.index_at(to_double(a)) == map.index_at(to_double(b)))
        widest = std::fmax(widest, far);
      else
        gap = std::fmin(gap, far);
    }
  EXPECT_LT(widest, gap);
}

TEST(CellMap, EveryFrameHasASiteEvenOfOne) {
  const Solid solid = solid_of(table());
  for (const SitePattern& pattern :
       {SitePattern(UniformPattern{}),
        SitePattern(ImpactPattern{.impacts = {{0.15, 0.5, 0.15}}, .radius = 0.1}),
        SitePattern(ClusteredPattern{})}) {
    SiteParameters p;
    p.sites = 1;
    p.pattern = pattern;
    p.anisotropy = {.stretch = 5, .grain_of = GrainOf::kPart};
    SitePlan plan = plan_sites(solid, p, {}).value();
    fill_frames(SeenSolid(solid, plan.map, {}), plan, {});
    EXPECT_LE(plan.points.size(), 2u);
    std::set<std::size_t> frames;
    for (const Vec3d& site : plan.points) frames.insert(plan.map.index_at(site));
    EXPECT_EQ(frames.size(), 2u);
  }
}

TEST(CellMap, SitesOfAnImpactAreNearItWhateverTheGrain) {
  const Solid solid = solid_of(table());
  SiteParameters p;
  p.sites = 60;
  const Vec3d corner{0.15, 0.99, 0.15};  // a leg and the top meet here
  p.pattern = ImpactPattern{.impacts = {corner}, .radius = 0.2, .share = 1};
  p.anisotropy = {.stretch = 2, .grain_of = GrainOf::kPart};
  const SitePlan plan = plan_sites(solid, p, {}).value();
  std::size_t near = 0;
  std::set<std::size_t> frames;
  for (const Vec3d& site : plan.points) {
    if (length(plan.map.at(site).place(site) - corner) > 0.41) continue;
    ++near;
    frames.insert(plan.map.index_at(site));
  }
  EXPECT_GT(near, 50u);
  EXPECT_EQ(frames.size(), 2u);
}

TEST(CellMap, PatternsOfPlanesHaveOneGrain) {
  SiteParameters p;
  p.pattern = GridPattern{};
  p.anisotropy = {.stretch = 5, .grain_of = GrainOf::kPart};
  EXPECT_EQ(map_of_cells(solid_of(table()), p, {})->frames().size(), 1u);
}

}  // namespace
}  // namespace fracture::test
