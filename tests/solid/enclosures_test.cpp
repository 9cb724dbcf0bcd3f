// The choices of make_solid(): walls for rooms and for pieces with large lids, and a weld tolerance for cracks.
#include "common/solid/enclosures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/solid/solid.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

const Choice* choice(const Solid& solid, const char* kind) {
  const std::vector<Choice>& choices = solid.report.choices;
  const auto found =
      std::find_if(choices.begin(), choices.end(), [&](const Choice& each) { return each.kind == kind; });
  return found == choices.end() ? nullptr : &*found;
}

/// The value of its only parameter.
double value_of(const Choice& choice, const char* name) {
  EXPECT_EQ(choice.parameters.size(), 1u);
  EXPECT_EQ(choice.parameters[0].name, name);
  return std::get<double>(choice.parameters[0].value);
}

TEST(Choices, AClosedOutwardMeshHasNone) {
  for (const auto& [name, mesh] : closed_shapes()) EXPECT_TRUE(solid_of(mesh).report.choices.empty()) << name;
}

TEST(Choices, ARoomIsTurnedAndWallsAreOffered) {
  const Solid block = solid_of(reversed(scaled(cube(8), {4, 3, 2})));
  EXPECT_NEAR(block.report.volume, 24, 1e-9) << "as it was";
  ASSERT_EQ(block.report.choices.size(), 1u);
  const Choice* const room = choice(block, "room");
  ASSERT_TRUE(room);
  EXPECT_EQ(value_of(*room, "thickness"), 0.04) << "a hundredth of the longest side";
  EXPECT_TRUE(room->text.starts_with("1 closed piece faces inwards, the first at (")) << room->text;
}

TEST(Choices, ThicknessMakesWallsOutsideOfARoom) {
  const Mesh room = reversed(cube(8));
  const Solid solid = solid_of(room, {.thickness = 0.1});
  ASSERT_NO_THROW(solid.validate());
  EXPECT_TRUE(solid.report.choices.empty());
  EXPECT_EQ(solid.parts.size(), 1u);
  EXPECT_EQ(solid.report.cavities, 1u);
  EXPECT_EQ(solid.report.flipped, 0u);
  EXPECT_EQ(solid.report.rooms_walled, 1u);
  EXPECT_EQ(solid.report.holes_filled, 0u);
  // The walls' outer sides are a cube of side 1.2.
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(solid.box.min[axis], -0.6, 1e-6);
    EXPECT_NEAR(solid.box.max[axis], 0.6, 1e-6);
  }
  EXPECT_NEAR(solid.report.volume, 1.2 * 1.2 * 1.2 - 1, 1e-5);
  // The faces of the file are the walls' inner sides: where they were, and facing as they did.
  std::size_t kept = 0;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    if (solid.wedges[t][0] == kNoIndex) continue;
    ++kept;
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(solid.positions[solid.triangles[t][k]], room.positions[solid.wedges[t][k]]);
  }
  EXPECT_EQ(kept, room.triangles.size());
}

TEST(Choices, FurnitureStaysSolidInARoomWithWalls) {
  const Mesh mesh = joined({reversed(scaled(cube(8), {4, 4, 4})), translated(cube(), {1, 1, 0})});
  EXPECT_TRUE(choice(solid_of(mesh), "room"));
  const Solid solid = solid_of(mesh, {.thickness = 0.1});
  ASSERT_NO_THROW(solid.validate());
  ASSERT_EQ(solid.parts.size(), 2u);
  EXPECT_EQ(solid.report.rooms_walled, 1u);
  const Solid empty = solid_of(reversed(scaled(cube(8), {4, 4, 4})), {.thickness = 0.1});
  EXPECT_NEAR(solid.report.volume, empty.report.volume + 1, 1e-9);
}

TEST(Choices, ACavityAndASmallPieceAreNoRooms) {
  const Mesh bottle = joined({scaled(cube(4), {2, 2, 2}), reversed(cube())});
  const Mesh button = joined({cube(4), translated(reversed(scaled(cube(), {0.1, 0.1, 0.1})), {2, 0, 0})});
  for (const Mesh& mesh : {bottle, button}) {
    const Solid solid = solid_of(mesh), thick = solid_of(mesh, {.thickness = 0.01});
    EXPECT_FALSE(choice(solid, "room"));
    EXPECT_EQ(thick.report.rooms_walled, 0u);
    EXPECT_EQ(thick.report.volume, solid.report.volume);
  }
}

TEST(Choices, StrictRefusesARoomWithAnyThickness) {
  const Expected<Solid> solid = try_solid(reversed(cube()), {.repair = Repair::kStrict, .thickness = 0.1});
  ASSERT_FALSE(solid);
  EXPECT_EQ(solid.error().code, ErrorCode::kMeshNotClosed);
}

TEST(Choices, ALidOfMoreThanATenthIsNamed) {
  const Solid bucket = solid_of(cube_without({5}));
  EXPECT_EQ(bucket.report.volume, 1) << "as it was";
  ASSERT_EQ(bucket.report.choices.size(), 1u);
  const Choice* const lid = choice(bucket, "lid");
  ASSERT_TRUE(lid);
  EXPECT_EQ(value_of(*lid, "thickness"), 0.01);
  EXPECT_NE(lid->text.find("20 % of the area of its piece"), std::string::npos) << lid->text;

  // A box of 1 x 1 x height without its top: the lid has an area of 1, and the rest of 1 + 4 height.
  const auto tube = [](double height) {
    Mesh mesh = box({-0.5, -0.5, 0}, {0.5, 0.5, height});
    std::erase_if(mesh.triangles, [&](const auto& t) {
      return std::all_of(t.begin(), t.end(), [&](auto v) { return mesh.positions[v].z > 0; });
    });
    mesh.material.resize(mesh.triangles.size());
    mesh.node.resize(mesh.triangles.size());
    return solid_of(mesh);
  };
  EXPECT_TRUE(choice(tube(2), "lid")) << "1 of 9";
  EXPECT_FALSE(choice(tube(2.5), "lid")) << "1 of 11";
}

TEST(Choices, ACrackIsJoinedByTheToleranceThatIsOffered) {
  const auto cracked = [](float gap) {
    Mesh mesh = unindexed(cube(4));
    for (const auto& t : mesh.triangles) {
      const bool right = std::all_of(t.begin(), t.end(), [&](auto v) { return mesh.positions[v].x >= 0; });
      for (const auto v : t)
        if (right) mesh.positions[v].x += gap;
    }
    return mesh;
  };
  const Mesh mesh = cracked(0.0003f);
  const Solid apart = solid_of(mesh);
  EXPECT_EQ(apart.parts.size(), 2u) << "as it was";
  const Choice* const crack = choice(apart, "crack");
  ASSERT_TRUE(crack);
  // 0.0003 m of a diagonal of 1.732 m
  EXPECT_EQ(value_of(*crack, "weld_tolerance"), 2e-4);
  EXPECT_TRUE(crack->text.starts_with("32 open edges are within ")) << crack->text;

  const Solid joined = solid_of(mesh, {.weld_tolerance = 2e-4});
  ASSERT_NO_THROW(joined.validate());
  EXPECT_EQ(joined.parts.size(), 1u);
  EXPECT_EQ(joined.report.holes_filled, 0u);
  EXPECT_TRUE(joined.report.choices.empty());

  EXPECT_FALSE(choice(solid_of(cracked(0.003f)), "crack")) << "more than a thousandth of the size";
  EXPECT_TRUE(choice(solid_of(cracked(0.0003f), {.weld_tolerance = 0}), "crack"));
}

// At a thousandth of the size, all vertices of such fine loops would merge, and no edge would be left to join.
TEST(Choices, ACrackInAFineMeshIsFound) {
  Mesh mesh = unindexed(uv_sphere(12, 6000));
  for (const auto& t : mesh.triangles)
    for (const auto v : t)
      if (std::all_of(t.begin(), t.end(), [&](auto w) { return mesh.positions[w].z >= -1e-6f; }))
        mesh.positions[v].z += 2e-5f;
  const Solid solid = solid_of(mesh);
  const Choice* const crack = choice(solid, "crack");
  ASSERT_TRUE(crack);
  EXPECT_EQ(value_of(*crack, "weld_tolerance"), 1e-5)
      << "0.00002 m of a diagonal of 3.46 m; an edge has 0.001 m";
}

TEST(Choices, TheMountainIsNoBlock) {
  const auto file = find_test_mesh("mountain_open.obj");
  if (!file) GTEST_SKIP() << "mountain_open.obj is absent";
  const Expected<Mesh> mesh = load_mesh(*file);
  if (!mesh) GTEST_SKIP() << mesh.error().detail;
  const Solid block = solid_of(*mesh);
  const Choice* const lid = choice(block, "lid");
  ASSERT_TRUE(lid);
  const Solid sheet = solid_of(*mesh, {.thickness = value_of(*lid, "thickness")});
  ASSERT_NO_THROW(sheet.validate());
  EXPECT_EQ(sheet.report.sheets_thickened, 1u);
  EXPECT_LT(sheet.report.volume, block.report.volume / 2);
}

}  // namespace
}  // namespace fracture::test
