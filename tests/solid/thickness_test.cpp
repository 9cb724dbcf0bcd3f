#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/solid/solid.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

Expected<Solid> thickened(Mesh mesh, double thickness) {
  return try_solid(std::move(mesh), {.thickness = thickness});
}

std::size_t warnings_on_thickness(const Solid& solid) {
  const std::vector<std::string>& warnings = solid.report.remarks.warnings;
  return static_cast<std::size_t>(
      std::count_if(warnings.begin(), warnings.end(),
                    [](const std::string& warning) { return warning.starts_with("'thickness'"); }));
}

/// n × n squares over the unit square in the plane z = 0, facing +z.
Mesh sheet(int n) {
  Mesh mesh = cube(n);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    for (const auto v : t)
      if (mesh.positions[v].z != 0.5f) return true;
    return false;
  });
  mesh.material.assign(mesh.triangles.size(), 7);
  mesh.node.assign(mesh.triangles.size(), 0);
  return translated(mesh, {0.5, 0.5, -0.5});
}

TEST(Thickness, AQuadBecomesASlabBehindItsFace) {
  const Expected<Solid> solid = thickened(open_quad(), 0.25);
  ASSERT_TRUE(solid) << solid.error().detail;
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.sheets_thickened, 1u);
  EXPECT_EQ(solid->triangles.size(), 12u);
  EXPECT_EQ(solid->report.volume, 0.25);
  EXPECT_EQ(solid->report.area, 3);
  EXPECT_EQ(solid->box.max.z, 0);
  EXPECT_EQ(solid->box.min.z, -0.25);
  EXPECT_EQ(solid->report.holes_filled, 0u);
  std::size_t front = 0;
  for (std::size_t t = 0; t < 12; ++t) front += solid->wedges[t][0] != kNoIndex;
  EXPECT_EQ(front, 2u) << "the back and the walls are not of the source";
}

TEST(Thickness, ZeroRefusesTheQuad) {
  EXPECT_EQ(thickened(open_quad(), 0).error().code, ErrorCode::kMeshNotClosed);
}

TEST(Thickness, ASubdividedSheetWithAHoleBecomesASlabWithAHole) {
  Mesh mesh = sheet(5);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    for (const auto v : t)
      if (std::fabs(mesh.positions[v].x - 0.5f) > 0.11f || std::fabs(mesh.positions[v].y - 0.5f) > 0.11f)
        return false;
    return true;
  });
  mesh.material.resize(mesh.triangles.size());
  mesh.node.resize(mesh.triangles.size());
  ASSERT_EQ(mesh.triangles.size(), 48u);
  const Expected<Solid> solid = thickened(mesh, 0.5);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_NEAR(solid->report.volume, 0.48, 1e-6);
  EXPECT_NEAR(solid->report.area, 2 * 0.96 + 0.5 * (4 + 0.8), 1e-6);
}

TEST(Thickness, ASheetGivenFromBothSidesKeepsBothAndTheirWedges) {
  const Mesh front = sheet(2);
  Mesh mesh = joined({front, reversed(front)});
  mesh.material.assign(mesh.triangles.size(), 1);
  for (std::size_t t = front.triangles.size(); t < mesh.triangles.size(); ++t) mesh.material[t] = 2;
  const Expected<Solid> solid = thickened(mesh, 0.125);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.volume, 0.125);
  std::size_t front_count = 0, back_count = 0;
  for (std::size_t t = 0; t < solid->triangles.size(); ++t) {
    if (solid->wedges[t][0] == kNoIndex) continue;
    (solid->material[t] == 1 ? front_count : back_count)++;
    for (int k = 0; k < 3; ++k) {
      const Vec3f& p = solid->positions[solid->triangles[t][k]];
      const Vec3f& q = mesh.positions[solid->wedges[t][k]];
      EXPECT_EQ(p.x, q.x);
      EXPECT_EQ(p.y, q.y);
    }
  }
  EXPECT_EQ(front_count, 8u);
  EXPECT_EQ(back_count, 8u);
}

/// Without the triangles that have a corner for which `gone` is true.
template <class Gone>
Mesh without(Mesh mesh, const Gone& gone) {
  std::erase_if(mesh.triangles, [&](const auto& t) {
    for (const auto v : t)
      if (gone(mesh.positions[v])) return true;
    return false;
  });
  mesh.material.resize(mesh.triangles.size());
  mesh.node.resize(mesh.triangles.size());
  return mesh;
}

/// A cube of volume 1 whose +z face lacks the triangles around its middle: a hole of at most 1/12 of the face.
Mesh cube_with_small_hole() {
  return without(cube(8), [](const Vec3f& p) { return p.x == 0 && p.y == 0 && p.z == 0.5f; });
}

TEST(Thickness, LeavesSolidsAndSmallHolesAlone) {
  const Expected<Solid> solid = thickened(
      joined({cube(), translated(cube_with_small_hole(), {3, 0, 0}), translated(open_quad(), {6, 0, 0})}),
      0.1);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.sheets_thickened, 1u);
  EXPECT_NEAR(solid->report.volume, 2.1, 1e-7);
  EXPECT_EQ(solid->report.holes_filled, 1u);
  EXPECT_EQ(warnings_on_thickness(*solid), 1u) << "the cube with a hole";
}

// The faces are the outer sides of the walls, and the lid is gone.
TEST(Thickness, MakesWallsOfAPieceThatOnlyALargeLidCloses) {
  const Mesh mesh = without(
      cube(8), [](const Vec3f& p) { return p.z == 0.5f && std::fabs(p.x) < 0.5f && std::fabs(p.y) < 0.5f; });
  const Expected<Solid> solid = thickened(mesh, 0.1);
  ASSERT_TRUE(solid) << solid.error().detail;
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.sheets_thickened, 1u);
  EXPECT_EQ(solid->report.holes_filled, 0u);
  EXPECT_EQ(solid->parts.size(), 1u);
  EXPECT_EQ(warnings_on_thickness(*solid), 0u) << "the edges of the cube are mitred";
  // Five walls of 1 x 1 x 0.1, which overlap along eight edges. The rim of triangles around the lid is left.
  EXPECT_GT(solid->report.volume, 1 - 0.8 * 0.8 * 0.9 - 0.1);
  EXPECT_LT(solid->report.volume, 0.6);
}

// The upper half of a sphere of radius 1, open below: its lid has half of its area.
TEST(Thickness, MakesAShellOfADome) {
  const Expected<Solid> solid =
      thickened(without(uv_sphere(32, 64), [](const Vec3f& p) { return p.z < -1e-6f; }), 0.05);
  ASSERT_TRUE(solid) << solid.error().detail;
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.holes_filled, 0u);
  const double exact = 2.0 / 3 * 3.14159265358979 * (1 - 0.95 * 0.95 * 0.95);
  EXPECT_NEAR(solid->report.volume, exact, 0.02 * exact);
}

TEST(Thickness, SaysThatACurvedSheetBecameABody) {
  const Mesh mesh =
      without(uv_sphere(16, 32), [](const Vec3f& p) { return p.z > 0.99f; });  // a pole is missing
  const Expected<Solid> solid = thickened(mesh, 0.01);
  ASSERT_TRUE(solid) << solid.error().detail;
  EXPECT_EQ(solid->report.sheets_thickened, 0u);
  ASSERT_EQ(warnings_on_thickness(*solid), 1u);
  // 4/3 pi is 33 times a slab of 4 pi x 0.01. For polygons the factor is slightly smaller.
  const std::string times = "gives 3";
  EXPECT_NE(solid->report.remarks.warnings[0].find(times), std::string::npos)
      << solid->report.remarks.warnings[0];
  EXPECT_NE(solid->report.remarks.warnings[0].find("modelling tool"), std::string::npos);
  const Expected<Solid> closed = thickened(uv_sphere(16, 32), 0.01);
  ASSERT_TRUE(closed);
  EXPECT_EQ(warnings_on_thickness(*closed), 0u) << "nothing was filled";
  const Expected<Solid> not_asked = thickened(mesh, 0);
  ASSERT_TRUE(not_asked);
  EXPECT_EQ(warnings_on_thickness(*not_asked), 0u);
}

/// Three squares in the shape of a Z, facing up; `turn` is the turning angle at its folds.
Mesh folded(const CirclePoint& turn) {
  Mesh mesh;
  for (const auto& [x, z] :
       {std::pair(-1.0, 0.0), {0.0, 0.0}, {turn.cos, turn.sin}, {turn.cos + 1, turn.sin}})
    for (const float y : {0.0f, 1.0f})
      mesh.positions.push_back({static_cast<float>(x), y, static_cast<float>(z)});
  // Each corner of a fold has equally many triangles on both sides of the fold.
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {2, 4, 3}, {4, 5, 3}, {4, 6, 7}, {4, 7, 5}};
  return mesh;
}

TEST(Thickness, IsReachedAtFoldsByMitres) {
  for (const std::int64_t k : {1, 3, 8}) {  // turns of 10, 30 and 80 degrees
    const CirclePoint turn = circle_point(k, 36);
    const Expected<Solid> solid = thickened(folded(turn), 0.05);
    ASSERT_TRUE(solid) << solid.error().detail;
    ASSERT_NO_THROW(solid->validate());
    EXPECT_EQ(warnings_on_thickness(*solid), 0u);
    // Behind the first fold, the planes parallel to both squares at a distance of 0.05 m intersect at z = -0.05 and
    // x = 0.05 · tan(half the angle).
    const double tangent = turn.sin / (1 + turn.cos);
    int found = 0;
    for (const Vec3f& p : solid->positions)
      found += std::fabs(p.z + 0.05) < 1e-6 && std::fabs(p.x - 0.05 * tangent) < 1e-6;
    EXPECT_EQ(found, 2) << "at y = 0 and y = 1";
  }
}

TEST(Thickness, SaysWhereAFoldIsThinnerThanAsked) {
  // A mitre of a turn of 165 degrees would be 7.7 times as long as the slab is thick, and the limit is 4. Then the
  // slab is 4 · cos(82.5°) = 0.522 times as thick.
  const Expected<Solid> thin = thickened(folded(circle_point(11, 24)), 0.2);
  ASSERT_TRUE(thin) << thin.error().detail;
  EXPECT_EQ(thin->report.sheets_thickened, 1u);
  ASSERT_EQ(warnings_on_thickness(*thin), 1u);
  EXPECT_NE(thin->report.remarks.warnings[0].find("6 triangles"), std::string::npos)
      << thin->report.remarks.warnings[0];
  EXPECT_NE(thin->report.remarks.warnings[0].find(" 0.1044 m"), std::string::npos)
      << thin->report.remarks.warnings[0];
  const Expected<Solid> even = thickened(folded(circle_point(1, 36)), 0.2);
  ASSERT_TRUE(even);
  EXPECT_EQ(warnings_on_thickness(*even), 0u);
}

TEST(Thickness, ABentSheetFollowsItsNormals) {
  // A strip of a cylinder of radius 1, a quarter turn, height 1, facing outwards.
  constexpr int kSteps = 32;
  Mesh mesh;
  for (int i = 0; i <= kSteps; ++i) {
    const CirclePoint p = circle_point(i, 4 * kSteps);
    mesh.positions.push_back({static_cast<float>(p.cos), static_cast<float>(p.sin), 0});
    mesh.positions.push_back({static_cast<float>(p.cos), static_cast<float>(p.sin), 1});
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  const Expected<Solid> solid = thickened(mesh, 0.3);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  const double exact = 3.14159265358979 / 4 * (1 - 0.7 * 0.7);
  EXPECT_NEAR(solid->report.volume, exact, 0.01 * exact);
}

// Float32 has steps of 1/256 here. The back of corner u of a large triangle falls on corner v of a narrow
// neighbour, one thickness behind u. The wall on their edge u -> v then needs its other diagonal.
TEST(Thickness, AWallWhoseDiagonalRoundsToAPointTakesTheOther) {
  constexpr float kFar = 32768;
  Mesh mesh;
  mesh.positions = {
      {kFar, kFar, kFar}, {kFar, kFar + 1000, kFar}, {kFar, kFar, kFar + 1000}, {kFar - 1, kFar, kFar}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  const Expected<Solid> solid = thickened(mesh, 1);
  ASSERT_TRUE(solid) << solid.error().detail;
  EXPECT_EQ(solid->report.sheets_thickened, 1u);
  EXPECT_NO_THROW(solid->validate());
}

TEST(Thickness, TooThinForFloat32IsRefused) {
  EXPECT_FALSE(thickened(translated(open_quad(), {1000, 1000, 1000}), 1e-6));
}

TEST(Thickness, TheSoupBecomesSlabs) {
  const auto file = find_test_mesh("soup.stl");
  if (!file) GTEST_SKIP() << "soup.stl is absent";
  const Expected<Mesh> mesh = load_mesh(*file);
  if (!mesh) GTEST_SKIP() << mesh.error().detail;
  const Expected<Solid> solid = thickened(*mesh, 0.01);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->parts.size(), 100u);
  EXPECT_NEAR(solid->report.volume, 0.01 * area_of(*mesh), 1e-4 * solid->report.volume);
}

}  // namespace
}  // namespace fracture::test
