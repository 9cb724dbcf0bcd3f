// Vessels that a file has from both sides: only the outer sides become the surface of the solid.
#include "common/solid/doubled_vessels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/solid/solid.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

Mesh without_triangles(Mesh mesh, const std::vector<std::size_t>& left_out) {
  std::vector<std::array<std::uint32_t, 3>> kept;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (std::find(left_out.begin(), left_out.end(), t) == left_out.end()) kept.push_back(mesh.triangles[t]);
  mesh.triangles = kept;
  mesh.material.resize(kept.size(), kNoIndex);
  mesh.node.resize(kept.size(), 0);
  return mesh;
}

/// The cube with n × n squares per face, without its face +y: 10 n² triangles.
Mesh tub(int n = 1) {
  const Mesh whole = cube(n);
  std::vector<std::size_t> top;
  for (std::size_t t = 0; t < whole.triangles.size(); ++t)
    if (std::all_of(whole.triangles[t].begin(), whole.triangles[t].end(),
                    [&](std::uint32_t v) { return whole.positions[v].y == 0.5f; }))
      top.push_back(t);
  return without_triangles(whole, top);
}

/// Triangles of `outer` have material 0, the others 1.
Mesh with_both_sides(const Mesh& outer, bool outer_first) {
  const Mesh inner = reversed(outer);
  Mesh mesh = outer_first ? joined({outer, inner}) : joined({inner, outer});
  mesh.material.assign(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.material[t] = (t < outer.triangles.size()) == outer_first ? 0 : 1;
  return mesh;
}

TEST(DoubledVessels, AreClosedLikeThoseWithOneSide) {
  for (const int n : {1, 4})
    for (const bool outer_first : {true, false}) {
      const Mesh one = tub(n);
      const Mesh both = with_both_sides(one, outer_first);
      const Solid solid = solid_of(both), twin = solid_of(one);
      ASSERT_NO_THROW(solid.validate());
      EXPECT_EQ(solid.report.volume, 1);
      EXPECT_EQ(solid.report.area, 6);
      EXPECT_EQ(solid.parts.size(), 1u);
      EXPECT_EQ(solid.report.duplicates_dropped, one.triangles.size());
      EXPECT_EQ(solid.report.flipped, 0u) << "the outer sides face outwards";
      EXPECT_EQ(solid.report.open_edges, 4u * static_cast<unsigned>(n));
      EXPECT_EQ(solid.report.holes_filled, 1u);
      EXPECT_EQ(solid.report.fill_triangles, twin.report.fill_triangles);
      EXPECT_EQ(std::count(solid.material.begin(), solid.material.end(), 0u),
                static_cast<std::ptrdiff_t>(one.triangles.size()));
      EXPECT_EQ(std::count(solid.material.begin(), solid.material.end(), 1u), 0) << "the inner sides";
      const std::vector<std::string>& notes = solid.report.remarks.notes;
      EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
        return note.starts_with(
            "1 open piece has every triangle twice, once for each side, and is a vessel.");
      }));
    }
}

TEST(DoubledVessels, StayNextToOtherPieces) {
  const Mesh handle = translated(scaled(cube(), {0.5, 0.5, 0.5}), {3, 0, 0});
  const Solid solid = solid_of(joined({with_both_sides(tub(), true), handle}));
  ASSERT_NO_THROW(solid.validate());
  EXPECT_EQ(solid.parts.size(), 2u);
  EXPECT_EQ(solid.report.volume, 1.125);
  EXPECT_EQ(solid.report.sheet_triangles, 0u);
}

TEST(DoubledVessels, MayLackSomeTrianglesOnOneSide) {
  const Mesh whole = with_both_sides(tub(8), true);
  ASSERT_EQ(whole.triangles.size(), 2u * 640u);
  for (const std::size_t missing : {std::size_t{17}, std::size_t{640 + 17}}) {
    const Solid solid = solid_of(without_triangles(whole, {missing}));
    ASSERT_NO_THROW(solid.validate());
    EXPECT_EQ(solid.report.volume, 1) << missing;
    EXPECT_EQ(solid.report.duplicates_dropped, 639u);
    EXPECT_EQ(solid.report.holes_filled, 1u);
  }
}

/// The part of the unit sphere below this height.
Mesh bowl(float height) {
  const Mesh ball = uv_sphere(40, 48);
  std::vector<std::size_t> above;
  for (std::size_t t = 0; t < ball.triangles.size(); ++t)
    if (std::any_of(ball.triangles[t].begin(), ball.triangles[t].end(),
                    [&](std::uint32_t v) { return ball.positions[v].z > height; }))
      above.push_back(t);
  return joined({without_triangles(ball, above), translated(scaled(cube(), {0.5, 0.5, 0.5}), {5, 0, 0})});
}

// The opening of a cap with the height h has 1 - h / 2 of the area of the cap.
TEST(DoubledVessels, BowlsAreClosedAndDishesAreSheets) {
  const Solid deep = solid_of(with_both_sides(bowl(-0.2f), true)),
              flat = solid_of(with_both_sides(bowl(-0.7f), true));
  ASSERT_NO_THROW(deep.validate());
  EXPECT_EQ(deep.report.holes_filled, 1u);
  EXPECT_FALSE(deep.sheets);
  EXPECT_GT(deep.report.volume, 1) << "a cap with the height 0.8 has a volume of 1.47";
  ASSERT_NO_THROW(flat.validate());
  EXPECT_EQ(flat.report.holes_filled, 0u);
  EXPECT_TRUE(flat.sheets);
  EXPECT_NEAR(flat.report.volume, 0.125, 1e-6) << "only the cube";
}

// Two squares at a right angle: the fills would have more area than the squares.
TEST(DoubledVessels, SheetsKeepBothSides) {
  const Mesh fold = cube_without({0, 1, 3, 5});
  const Solid solid = solid_of(joined({with_both_sides(fold, true), translated(cube(), {5, 0, 0})}));
  ASSERT_NO_THROW(solid.validate());
  EXPECT_EQ(solid.report.duplicates_dropped, 0u);
  EXPECT_EQ(solid.report.volume, 1);
  ASSERT_TRUE(solid.sheets);
  EXPECT_EQ(solid.sheets->triangles.size(), 8u);
}

// The common walls of touching plates are there from both sides and have 97 % of the area.
TEST(DoubledVessels, TouchingBodiesStayBodies) {
  const Mesh plate = box({-0.5, -0.5, -1.0 / 256}, {0.5, 0.5, 1.0 / 256});
  std::vector<Mesh> stack;
  for (int k = 0; k < 60; ++k)  // mirrored, so that the triangles of common walls are the same
    stack.push_back(translated(k % 2 == 0 ? plate : scaled(plate, {1, 1, -1}), {0, 0, k / 128.0}));
  const Solid solid = solid_of(joined(stack));
  ASSERT_NO_THROW(solid.validate());
  EXPECT_EQ(solid.report.duplicates_dropped, 0u);
  EXPECT_EQ(solid.parts.size(), 60u);
  EXPECT_EQ(solid.report.volume, 60 / 128.0);
}

TEST(DoubledVessels, ThicknessMakesWallsOfBothSides) {
  const Solid solid = solid_of(with_both_sides(tub(), true), {.thickness = 0.05});
  ASSERT_NO_THROW(solid.validate());
  EXPECT_EQ(solid.report.sheets_thickened, 1u);
  EXPECT_EQ(solid.report.duplicates_dropped, 0u);
  // The inner space of the walls is 0.9 x 0.95 x 0.9.
  EXPECT_NEAR(solid.report.volume, 1 - 0.9 * 0.95 * 0.9, 1e-6);
}

TEST(DoubledVessels, AreRefusedByTheStrictMode) {
  EXPECT_FALSE(try_solid(with_both_sides(tub(), true), {.repair = Repair::kStrict}));
}

}  // namespace
}  // namespace fracture::test
