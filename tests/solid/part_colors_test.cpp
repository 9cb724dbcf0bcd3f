// The colour of a part: that of most of its surface.
#include <gtest/gtest.h>

#include "common/mesh/material_library.hpp"
#include "common/solid/solid.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

constexpr SurfaceColor kRed{{65535, 0, 0}, 1}, kBlue{{0, 0, 65535}, 1}, kDarkBlue{{0, 0, 49152}, 1},
    kUnknown{};

/// A cuboid with faces of 1, 1, 2, 2, 2 and 2 m², each made of two triangles.
Mesh cuboid() { return box({0, 0, 0}, {1, 1, 2}); }

/// Colours each triangle by the direction it faces.
template <class ColorOf>
Mesh painted(Mesh mesh, const ColorOf& color_of) {
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3d p = to_double(mesh.positions[a]);
    mesh.triangle_color.push_back(
        color_of(cross(to_double(mesh.positions[b]) - p, to_double(mesh.positions[c]) - p)));
  }
  return mesh;
}

TEST(PartColors, APartHasTheColorOfMostOfItsSurfaceByArea) {
  // 2 m² of red: a third of the triangles, but a fifth of the area.
  const Solid solid = solid_of(painted(cuboid(), [](const Vec3d& n) { return n.z != 0 ? kRed : kBlue; }));
  ASSERT_TRUE(solid.parts[0].color);
  EXPECT_EQ(*solid.parts[0].color, kBlue.light) << "not purple";
  const Solid other = solid_of(painted(cuboid(), [](const Vec3d& n) { return n.z != 0 ? kBlue : kRed; }));
  EXPECT_EQ(*other.parts[0].color, kRed.light);
}

TEST(PartColors, ShadesOfOneColorHaveTheirMean) {
  const Solid solid =
      solid_of(painted(cuboid(), [](const Vec3d& n) { return n.x != 0 ? kBlue : kDarkBlue; }));
  EXPECT_NEAR((*solid.parts[0].color)[2], 0.4 * 65535 + 0.6 * 49152, 1);
}

TEST(PartColors, WhatIsNotKnownDoesNotCount) {
  const Solid solid = solid_of(painted(cuboid(), [](const Vec3d& n) { return n.z != 0 ? kRed : kUnknown; }));
  EXPECT_EQ(*solid.parts[0].color, kRed.light);
  EXPECT_FALSE(solid_of(painted(cuboid(), [](const Vec3d&) { return kUnknown; })).parts[0].color);
  EXPECT_FALSE(solid_of(cuboid()).parts[0].color);
}

TEST(PartColors, FilledHolesHaveNoneAndEachPartItsOwn) {
  Mesh two = painted(joined({cuboid(), box({5, 0, 0}, {6, 1, 2})}), [](const Vec3d&) { return kRed; });
  for (std::size_t t = 12; t < 24; ++t) two.triangle_color[t] = kBlue;
  two.triangles.pop_back();  // a hole in the second one
  two.triangle_color.pop_back();
  two.material.pop_back();
  two.node.pop_back();
  const Solid solid = solid_of(std::move(two));
  ASSERT_EQ(solid.parts.size(), 2u);
  EXPECT_EQ(solid.report.holes_filled, 1u);
  EXPECT_EQ(*solid.parts[0].color, kRed.light);
  EXPECT_EQ(*solid.parts[1].color, kBlue.light);
}

TEST(PartColors, LightComesThroughPartsThatAreMostlyTranslucent) {
  Mesh mesh = cuboid();
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"alphaMode", "BLEND"}}, {{"name", "frame"}}};
  mesh.library = library;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double z = mesh.positions[mesh.triangles[t][0]].z;
    mesh.material[t] =
        z == mesh.positions[mesh.triangles[t][1]].z && z == mesh.positions[mesh.triangles[t][2]].z;
  }
  EXPECT_TRUE(solid_of(mesh).parts[0].translucent) << "all but the two small sides";
  for (std::uint32_t& slot : mesh.material) slot = 1 - slot;
  EXPECT_FALSE(solid_of(mesh).parts[0].translucent);
}

}  // namespace
}  // namespace fracture::test
