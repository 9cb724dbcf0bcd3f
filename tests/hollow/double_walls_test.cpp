// Warnings about parts that are thin shells around a hidden space.
#include "common/hollow/double_walls.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> warnings_of(Mesh mesh, const SolidOptions& options = {}, int threads = 1) {
  Solid solid = solid_of(std::move(mesh), options);
  solid.report.remarks = {};
  warn_of_double_walls(solid, {.threads = threads});
  return solid.report.remarks.warnings;
}

constexpr double kInner = 0.95;

Mesh double_wall() { return joined({ico_sphere(3), reversed(ico_sphere(3, kInner))}); }

/// The double wall without one triangle of each side. Six triangles connect the two holes.
Mesh leaking_wall() {
  const Mesh outer = ico_sphere(3), inner = reversed(ico_sphere(3, kInner));
  Mesh mesh = joined({outer, inner});
  const auto base = static_cast<std::uint32_t>(outer.positions.size());
  const std::size_t of_outer = 700, of_inner = outer.triangles.size() + of_outer;
  const auto removed = mesh.triangles[of_outer];
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(of_inner));
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(of_outer));
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = removed[k], b = removed[(k + 1) % 3];
    mesh.triangles.push_back({a, b, b + base});
    mesh.triangles.push_back({a, b + base, a + base});
  }
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  mesh.node.assign(mesh.triangles.size(), 0);
  return mesh;
}

TEST(DoubleWalls, AClosedOneNamesItsInnerShell) {
  const Solid solid = solid_of(double_wall());
  EXPECT_EQ(solid.report.cavities, 1u);
  const std::vector<std::string> warnings = warnings_of(double_wall());
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0],
              AllOf(HasSubstr("is a double wall: its inner shell (1,280 triangles, the first at ("),
                    HasSubstr("delete the inner shell"), Not(HasSubstr("leak"))));
}

TEST(DoubleWalls, ALeakIsNamedWithItsPlace) {
  const Solid solid = solid_of(leaking_wall());
  ASSERT_NO_THROW(solid.validate());
  EXPECT_EQ(solid.report.cavities, 0u);
  EXPECT_EQ(solid.report.shells, 1u);
  EXPECT_EQ(solid.report.holes_filled, 0u);
  const std::vector<std::string> warnings = warnings_of(leaking_wall());
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], AllOf(HasSubstr("is a double wall with a leak: its inner side (1,2"),
                                 HasSubstr("The only opening between the two sides is at ("),
                                 HasSubstr("close the opening")));
  EXPECT_EQ(warnings_of(leaking_wall(), {}, 4), warnings);
}

TEST(DoubleWalls, OthersAreCounted) {
  const std::vector<std::string> warnings = warnings_of(
      joined({double_wall(), translated(leaking_wall(), {5, 0, 0}), translated(cube(), {9, 0, 0})}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr(" 1 further part is a double wall."));
}

TEST(DoubleWalls, OtherPartsAreNot) {
  for (const auto& [name, mesh] : closed_shapes()) EXPECT_THAT(warnings_of(mesh), IsEmpty()) << name;
  EXPECT_THAT(warnings_of(joined({ico_sphere(3), reversed(ico_sphere(3, 0.6))})), IsEmpty()) << "thick";
  EXPECT_THAT(
      warnings_of(joined({scaled(cube(8), {1, 1, 0.02}), reversed(scaled(cube(), {0.1, 0.1, 0.01}))})),
      IsEmpty())
      << "a plate with a bubble";
}

// A cup with thin walls is a double wall too, but its opening is large, so it is meant.
TEST(DoubleWalls, AVesselIsNot) {
  Mesh tub = cube(8);
  std::erase_if(tub.triangles, [&](const auto& triangle) {
    return std::all_of(triangle.begin(), triangle.end(),
                       [&](std::uint32_t v) { return tub.positions[v].y == 0.5f; });
  });
  tub.material.assign(tub.triangles.size(), kNoIndex);
  tub.node.assign(tub.triangles.size(), 0);
  const Solid solid = solid_of(tub, {.thickness = 0.02});
  ASSERT_EQ(solid.report.sheets_thickened, 1u);
  ASSERT_EQ(solid.report.shells, 1u);
  EXPECT_THAT(warnings_of(tub, {.thickness = 0.02}), IsEmpty());
}

// Cavities of rooms are meant, too: the request asks for the walls around them.
TEST(DoubleWalls, WallsOfARoomAreNot) {
  const Mesh room = reversed(cube(8));
  ASSERT_EQ(solid_of(room, {.thickness = 0.02}).report.rooms_walled, 1u);
  EXPECT_THAT(warnings_of(room, {.thickness = 0.02}), IsEmpty());
}

}  // namespace
}  // namespace fracture::test
