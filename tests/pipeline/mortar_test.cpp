// The area in which the bricks of a wall part along their joints, and the area in which bricks break: both
// computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "common/clip/restricted_diagram.hpp"
#include "common/solid/cut_materials.hpp"
#include "tests/pipeline/looks.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

constexpr Vec3d kBrick{0.225, 0.075, 0.1125};  // length, height, depth
constexpr int kLong = 9, kCourses = 16, kDeep = 2;
constexpr Vec3d kWall{kLong * kBrick.x, kCourses* kBrick.y, kDeep* kBrick.z};

Mesh wall() { return box({0, 0, 0}, kWall, 3); }

FractureParameters bricks(BrickPattern pattern, std::uint32_t sites = 50) {
  FractureParameters p;
  p.sites = sites;
  p.pattern = std::move(pattern);
  return p;
}

/// The area of the cuts in m² by material, counting both sides.
std::map<std::uint32_t, double> areas_of_cuts(const FragmentSet& set) {
  std::map<std::uint32_t, double> areas;
  for (const Fragment& f : set.fragments)
    for (const FragmentPrimitive& p : f.primitives)
      for (std::uint32_t k = p.first_index; is_of_cuts(p.material) && k < p.first_index + p.index_count;
           k += 3) {
        const Vec3d a = world(f, f.indices[k]);
        areas[p.material] +=
            0.5 * length(cross(world(f, f.indices[k + 1]) - a, world(f, f.indices[k + 2]) - a));
      }
  return areas;
}

/// All bed joints, the joint between the two wythes, and the head joints. A course has one head joint fewer
/// than bricks; a shifted course begins and ends with half a brick.
double area_of_joints() {
  const double bed = (kCourses - 1) * kWall.x * kWall.z, wythe = (kDeep - 1) * kWall.x * kWall.y;
  const double head = kDeep * kCourses * ((kLong - 1) + kLong) / 2.0 * kBrick.y * kBrick.z;
  return 2 * (bed + wythe + head);
}

TEST(Mortar, OfAWallOfWholeBricksAllCutsAreJoints) {
  const FragmentSet set = fracture_mesh(wall(), bricks({.cell = kBrick, .mortar = true})).set;
  EXPECT_EQ(set.fragments.size(), std::size_t{kDeep} * kCourses / 2 * (kLong + kLong + 1));
  const auto areas = areas_of_cuts(set);
  EXPECT_EQ(areas.count(kInteriorMaterial), 0u) << "nothing is broken";
  EXPECT_NEAR(areas.at(kMortarMaterial), area_of_joints(), 1e-4 * area_of_joints());
}

TEST(Mortar, ABrickThatIsBrokenInHalvesIsBrokenAcrossItsMiddle) {
  // Nine pieces leave no crumb. One brick is halved: the one with the hit in its middle.
  const Vec3d hit{4.5 * kBrick.x, 8.5 * kBrick.y, 1.5 * kBrick.z};
  const FragmentSet off = fracture_mesh(wall(), bricks({.cell = kBrick, .impacts = {hit}}, 9)).set;
  const FragmentSet on =
      fracture_mesh(wall(), bricks({.cell = kBrick, .impacts = {hit}, .mortar = true}, 9)).set;
  const auto areas = areas_of_cuts(on);
  const double broken = 2 * kBrick.y * kBrick.z;
  ASSERT_EQ(areas.count(kInteriorMaterial), 1u);
  EXPECT_NEAR(areas.at(kInteriorMaterial), broken, 1e-4 * broken);
  EXPECT_NEAR(areas.at(kMortarMaterial), area_of_joints(), 1e-4 * area_of_joints());

  const auto without = areas_of_cuts(off);
  EXPECT_EQ(without.count(kMortarMaterial), 0u);
  EXPECT_NEAR(without.at(kInteriorMaterial), broken + area_of_joints(), 1e-4 * area_of_joints());
  ASSERT_EQ(on.fragments.size(), off.fragments.size());
  for (std::size_t k = 0; k < on.fragments.size(); ++k) {
    EXPECT_EQ(on.fragments[k].id, off.fragments[k].id);
    EXPECT_EQ(on.fragments[k].mass.volume, off.fragments[k].mass.volume);
    EXPECT_EQ(on.fragments[k].exterior_area, off.fragments[k].exterior_area);
  }
}

TEST(Mortar, CutsOfCrumbsAreBroken) {
  const Vec3d hit{0.5 * kWall.x, 0.5 * kWall.y, kWall.z};
  const Fractured made = fracture_mesh(wall(), bricks({.impacts = {hit}, .mortar = true}, 60));
  ASSERT_EQ(made.diagram.bricks.size(), made.diagram.sites.size());
  std::size_t crumbs = 0;
  for (const Fragment& f : made.set.fragments) {
    bool crumb = false;
    for (const SiteId s : f.sites) crumb = crumb || made.diagram.bricks[s] == kNoIndex;
    crumbs += crumb;
    if (!crumb) continue;
    for (const FragmentPrimitive& p : f.primitives) EXPECT_NE(p.material, kMortarMaterial);
  }
  EXPECT_EQ(crumbs, 12u) << "of 60 pieces a twentieth is bricks in quarters";
  EXPECT_EQ(areas_of_cuts(made.set).size(), 2u) << "others have joints";
}

TEST(Mortar, StonesOfRubblePartInTheirJoints) {
  const auto areas = areas_of_cuts(fracture_mesh(sphere_with(2000), bricks({.mortar = true})).set);
  ASSERT_EQ(areas.size(), 1u);
  EXPECT_EQ(areas.begin()->first, kMortarMaterial);
}

TEST(Mortar, PiecesOfAFragmentKeepIt) {
  const FractureParameters p = bricks({.mortar = true}, 20);
  const FragmentSet whole = fracture_mesh(wall(), p).set;
  const auto mortar_of = [](const std::map<std::uint32_t, double>& areas) {
    const auto at = areas.find(kMortarMaterial);
    return at == areas.end() ? 0 : at->second;
  };
  const Fragment& first = whole.fragments[0];
  FragmentSet alone;
  alone.fragments = {first};
  const FragmentSet parts = fracture_mesh_again(wall(), p, {first.id, 10, 1}).set;
  ASSERT_GE(parts.fragments.size(), 5u);
  const auto areas = areas_of_cuts(parts);
  ASSERT_GT(mortar_of(areas_of_cuts(alone)), 0);
  EXPECT_NEAR(mortar_of(areas), mortar_of(areas_of_cuts(alone)), 1e-5 * mortar_of(areas));
  EXPECT_GT(areas.at(kInteriorMaterial), 0) << "new cuts are through bricks";
}

}  // namespace
}  // namespace fracture::test
