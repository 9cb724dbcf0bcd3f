#include <gtest/gtest.h>

#include "common/solid/solid.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

Mesh centered_cube(double side) { return scaled(cube(), {side, side, side}); }
Mesh hollow(double side) { return reversed(centered_cube(side)); }

TEST(Nesting, ConcentricSpheresAlternateBetweenPartsAndCavities) {
  const Mesh mesh = nested_spheres(4, 400);
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  ASSERT_EQ(solid->parts.size(), 2u);
  EXPECT_EQ(solid->parts[0].shells, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(solid->parts[1].shells, (std::vector<std::uint32_t>{2, 3}));
  EXPECT_NEAR(solid->report.volume, volume_of(mesh), 1e-12);
  EXPECT_EQ(solid->report.cavities, 2u);
}

TEST(Nesting, AWholeFileInsideOutKeepsItsCavities) {
  const Mesh mesh = reversed(nested_spheres(4, 400));
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_NEAR(solid->report.volume, -volume_of(mesh), 1e-12);
  EXPECT_EQ(solid->report.flipped, mesh.triangles.size());
  EXPECT_EQ(solid->report.cavities, 2u);
}

TEST(Nesting, AnOutwardShellInsideAnotherIsAnOverlappingPart) {
  const Expected<Solid> solid = try_solid(joined({centered_cube(2), centered_cube(1)}));
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->parts.size(), 2u);
  EXPECT_EQ(solid->layers, 2u);
  EXPECT_EQ(solid->report.volume, 9);
}

TEST(Nesting, ACavityGoesToTheInnermostShellAroundIt) {
  // A part of side 8, its cavity of side 6, an island of side 4 in it, and the cavity of the island of side
  // 2.
  const Expected<Solid> solid = try_solid(joined({hollow(2), centered_cube(4), hollow(6), centered_cube(8)}));
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  ASSERT_EQ(solid->parts.size(), 2u);
  EXPECT_EQ(solid->parts[0].shells, (std::vector<std::uint32_t>{1, 0}));
  EXPECT_EQ(solid->parts[1].shells, (std::vector<std::uint32_t>{3, 2}));
  EXPECT_EQ(solid->report.volume, 8 * 8 * 8 - 6 * 6 * 6 + 4 * 4 * 4 - 2 * 2 * 2);
}

TEST(Nesting, ManyCavitiesInOneShell) {
  std::vector<Mesh> meshes{centered_cube(20)};
  for (int x = -4; x <= 4; ++x)
    for (int y = -4; y <= 4; ++y) meshes.push_back(translated(hollow(1), {2. * x, 2. * y, 0}));
  const Expected<Solid> solid = try_solid(joined(meshes));
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->parts.size(), 1u);
  EXPECT_EQ(solid->report.cavities, 81u);
  EXPECT_EQ(solid->report.volume, 8000 - 81);
}

TEST(Nesting, AnInwardShellBesideAnOutwardOneIsTurned) {
  const Expected<Solid> solid = try_solid(joined({centered_cube(1), translated(hollow(1), {3, 0, 0})}));
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->parts.size(), 2u);
  EXPECT_EQ(solid->report.flipped, 12u);
  EXPECT_EQ(solid->report.volume, 2);
}

TEST(Nesting, AnInwardShellInsideACavityIsTurnedIntoAnIsland) {
  const Expected<Solid> solid = try_solid(joined({centered_cube(8), hollow(6), hollow(2)}));
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.volume, 512 - 216 + 8);
  EXPECT_EQ(solid->report.flipped, 12u);
}

TEST(Nesting, RaysThroughVerticesAndEdgesAreCountedOnce) {
  // The probe's ray along +x runs exactly through a vertex, along edges and in faces of the enclosing,
  // subdivided cube.
  for (const double y : {0.0, 0.25, 0.5, -0.25}) {
    Mesh inner = translated(scaled(reversed(cube(2)), {0.25, 0.25, 0.25}), {0, y, 0});
    const Expected<Solid> solid = try_solid(joined({scaled(cube(8), {2, 2, 2}), inner}));
    ASSERT_TRUE(solid);
    EXPECT_EQ(solid->report.cavities, 1u) << y;
    EXPECT_EQ(solid->parts.size(), 1u) << y;
  }
}

TEST(Nesting, ACavityThatTouchesTheOuterShellInAVertexIsStillACavity) {
  // The cavity's corner lies in the middle of a face of the cube.
  Mesh cavity = reversed(tetrahedron());
  const Expected<Solid> solid = try_solid(joined({box({0, -1, -1}, {4, 3, 3}), cavity}));
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.cavities, 1u);
}

}  // namespace
}  // namespace fracture::test
