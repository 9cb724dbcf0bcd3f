#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/solid/solid.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

/// The answers of algorithm 25 and before.
constexpr SolidOptions kDropSheets{.sheets = SheetsMode::kDrop};

const SolidOptions kStrict{.repair = Repair::kStrict};

TEST(Holes, AMissingFaceOfACubeIsFilledFlatAndMarkedInterior) {
  for (int face = 0; face < 6; ++face) {
    const Expected<Solid> solid = try_solid(cube_without({face}));
    ASSERT_TRUE(solid);
    ASSERT_NO_THROW(solid->validate());
    EXPECT_EQ(solid->report.volume, 1);
    EXPECT_EQ(solid->report.area, 6);
    EXPECT_EQ(solid->report.open_edges, 4u);
    EXPECT_EQ(solid->report.fill_triangles, 2u);
    EXPECT_EQ(solid->report.filled_area, 1);
    std::size_t interior = 0;
    for (std::size_t t = 0; t < solid->triangles.size(); ++t)
      interior += solid->material[t] == kInteriorMaterial;
    EXPECT_EQ(interior, 2u);
  }
}

TEST(Holes, TwoNeighbouringFacesMakeOneBentHoleThatIsFilledAlongTheEdge) {
  const Expected<Solid> solid = try_solid(cube_without({0, 3}));
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.holes_filled, 1u);
  EXPECT_EQ(solid->report.volume, 1);  // the triangulation of smallest area follows the missing edge
}

TEST(Holes, StrictRefusesWithCountsAndASampleEdge) {
  const Expected<Solid> solid = try_solid(cube_without({1}), kStrict);
  ASSERT_FALSE(solid);
  EXPECT_EQ(solid.error().code, ErrorCode::kMeshNotClosed);
  EXPECT_EQ(solid.error().extra->at("open_edges"), 4);
  EXPECT_EQ(solid.error().extra->at("sample")[0], 0.5);
}

TEST(Holes, ALargePlanarHoleIsFilledWithItsExactArea) {
  // A cube without its subdivided top: a square loop of 4 n edges, far over the limit of the small method.
  constexpr int kN = 50;
  Mesh mesh = cube(kN);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return mesh.positions[t[0]].z == 0.5f && mesh.positions[t[1]].z == 0.5f && mesh.positions[t[2]].z == 0.5f;
  });
  mesh.material.resize(mesh.triangles.size());
  mesh.node.resize(mesh.triangles.size());
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.open_edges, 4u * kN);
  EXPECT_EQ(solid->report.fill_triangles, 4u * kN - 2);
  EXPECT_NEAR(solid->report.volume, 1, 1e-12);
  EXPECT_NEAR(solid->report.filled_area, 1, 1e-12);
}

TEST(Holes, AHoleThatTouchesItselfInAVertexIsFilledAsTwo) {
  // A face of cube(2) lacks two diagonally opposite quads at its middle vertex.
  Mesh mesh = cube(2);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    bool top = true, positive = true, negative = true;
    for (const auto v : t) {
      const Vec3f& p = mesh.positions[v];
      top &= p.z == 0.5f;
      positive &= p.x >= 0 && p.y >= 0;
      negative &= p.x <= 0 && p.y <= 0;
    }
    return top && (positive || negative);
  });
  mesh.material.resize(mesh.triangles.size());
  mesh.node.resize(mesh.triangles.size());
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.open_edges, 8u);
  EXPECT_EQ(solid->report.holes_filled, 2u);
  EXPECT_EQ(solid->report.volume, 1);
  EXPECT_EQ(solid->parts.size(), 1u);
}

TEST(Holes, AnOpenTubeGetsTwoEnds) {
  Mesh mesh = uv_sphere(12, 40);
  const std::size_t cap = 40;
  mesh.triangles.erase(mesh.triangles.end() - cap, mesh.triangles.end());
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + cap);
  mesh.material.resize(mesh.triangles.size());
  mesh.node.resize(mesh.triangles.size());
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.holes_filled, 2u);
  EXPECT_EQ(solid->report.open_edges, 80u);
  EXPECT_LT(solid->report.volume, volume_of(uv_sphere(12, 40)));
  EXPECT_GT(solid->report.volume, 0.95 * volume_of(uv_sphere(12, 40)));
}

TEST(Sheets, AQuadBesideACubeIsDroppedWithAWarningAndTheCubeStays) {
  const Expected<Solid> solid = try_solid(joined({translated(open_quad(), {5, 0, 0}), cube()}), kDropSheets);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.shells_dropped, 1u);
  EXPECT_EQ(solid->report.volume, 1);
  EXPECT_EQ(solid->box.max.x, 0.5);
  EXPECT_EQ(solid->report.fill_triangles, 0u) << "the fill of a dropped sheet is not counted";
  const auto& [warnings, notes] = solid->report.remarks;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("1 thin piece (2 of 14 triangles, the first at (")) << warnings[0];
  EXPECT_NE(warnings[0].find("has no volume and is not in the answer. Use 'thickness'"), std::string::npos)
      << warnings[0];
  EXPECT_TRUE(notes.empty()) << "nothing else was done";
}

TEST(Sheets, SeveralAreCountedAndTheNodeOfTheFirstIsNamed) {
  Mesh mesh = joined({cube(), translated(open_quad(), {5, 0, 0}), translated(open_quad(), {7, 0, 0})});
  mesh.node_names = {"Cube", "Face"};
  mesh.node.assign(mesh.triangles.size(), 1);
  for (int t = 0; t < 12; ++t) mesh.node[t] = 0;
  const Expected<Solid> solid = try_solid(mesh, kDropSheets);
  ASSERT_TRUE(solid);
  ASSERT_EQ(solid->report.remarks.warnings.size(), 1u);
  const std::string& warning = solid->report.remarks.warnings[0];
  EXPECT_TRUE(warning.starts_with("2 thin pieces (4 of 16 triangles, the first at (")) << warning;
  EXPECT_NE(warning.find(" in the node \"Face\") have no volume and are not in"), std::string::npos)
      << warning;
  mesh.node_names[1] = "x";
  for (int k = 0; k < 150; ++k) mesh.node_names[1] += "\u00e4";  // of two bytes: one is at the limit of 200
  const Expected<Solid> named = try_solid(mesh, kDropSheets);
  ASSERT_TRUE(named);
  EXPECT_NO_THROW((void)nlohmann::json(named->report.remarks.warnings).dump());
}

TEST(Repairs, AreNotesBecauseNothingIsToBeDoneAboutThem) {
  const Expected<Solid> one = try_solid(cube_without({2})), two = try_solid(cube_without({2, 3}));
  ASSERT_TRUE(one && two);
  for (const auto& [solid, words] : {std::pair(&*one, "1 hole was filled with 2 triangles in the material"),
                                     {&*two, "2 holes were filled with 4 triangles in the material"}}) {
    EXPECT_TRUE(solid->report.remarks.warnings.empty());
    ASSERT_EQ(solid->report.remarks.notes.size(), 1u);
    EXPECT_TRUE(solid->report.remarks.notes[0].starts_with(words)) << solid->report.remarks.notes[0];
  }
  Mesh turned = cube();
  std::swap(turned.triangles[0][1], turned.triangles[0][2]);
  const Expected<Solid> flipped = try_solid(turned);
  ASSERT_TRUE(flipped);
  EXPECT_EQ(flipped->report.remarks, (Remarks{{}, {"1 triangle was turned to face outwards."}}));
}

TEST(Sheets, AFinOnAnEdgeOfACubeIsCutOffAndDropped) {
  for (const Vec3f& tip :
       {Vec3f{3, 3, 0}, Vec3f{-3, 0.1f, 0}, Vec3f{0, 0, 0}, Vec3f{-3, -3, 0}})  // inside and outside
    for (const bool turned : {false, true}) {
      Mesh mesh = cube();
      const auto far = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(tip);
      const std::uint32_t a = mesh.triangles[0][turned ? 1 : 0], b = mesh.triangles[0][turned ? 0 : 1];
      mesh.triangles.push_back({a, b, far});
      mesh.material.push_back(kNoIndex);
      mesh.node.push_back(0);
      const Expected<Solid> solid = try_solid(mesh, kDropSheets);
      ASSERT_TRUE(solid);
      ASSERT_NO_THROW(solid->validate());
      EXPECT_EQ(solid->report.nonmanifold_edges, 1u);
      EXPECT_EQ(solid->report.volume, 1);
      EXPECT_EQ(solid->report.shells_dropped, 1u);
      EXPECT_EQ(solid->triangles.size(), 12u);
    }
}

TEST(Orientation, TheMinorityOfAPatchIsFlippedWithItsWedges) {
  Mesh mesh = cube_with_seams();
  std::swap(mesh.triangles[2][1], mesh.triangles[2][2]);
  std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.flipped, 2u);
  EXPECT_EQ(solid->report.volume, 1);
  for (std::size_t t = 0; t < 12; ++t)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(mesh.positions[solid->wedges[t][k]], solid->positions[solid->triangles[t][k]]);
  EXPECT_EQ(try_solid(mesh, kStrict).error().code, ErrorCode::kMeshNotClosed);
}

TEST(Orientation, AnInsideOutCubeIsTurned) {
  const Expected<Solid> solid = try_solid(inside_out_cube());
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.flipped, 12u);
  EXPECT_EQ(solid->report.volume, 1);
  EXPECT_FALSE(try_solid(inside_out_cube(), kStrict));
}

TEST(Orientation, AKleinBottleIsClosedSomewhereAndEndsAsASolidOrATypedRefusal) {
  const Expected<Solid> solid = try_solid(klein_bottle());
  if (solid) {
    EXPECT_NO_THROW(solid->validate());
    EXPECT_GT(solid->report.nonmanifold_edges, 0u);
  } else {
    EXPECT_EQ(solid.error().code, ErrorCode::kMeshNotClosed);
  }
  EXPECT_FALSE(try_solid(klein_bottle(), kStrict));
}

TEST(Duplicates, ASecondCopyOfABodyIsDropped) {
  for (const Mesh& copy : {cube(2), reversed(cube(2))}) {
    const Expected<Solid> solid = try_solid(joined({cube(2), copy}));
    ASSERT_TRUE(solid);
    ASSERT_NO_THROW(solid->validate());
    EXPECT_EQ(solid->report.duplicates_dropped, 48u);
    EXPECT_EQ(solid->report.volume, 1);
    EXPECT_EQ(solid->parts.size(), 1u);
  }
}

TEST(Duplicates, ACopiedFaceIsDropped) {
  for (const int copies : {1, 2, 3}) {
    Mesh mesh = cube();
    for (int i = 0; i < copies; ++i) mesh.triangles.push_back(mesh.triangles[4]);
    mesh.material.resize(mesh.triangles.size(), kNoIndex);
    mesh.node.resize(mesh.triangles.size(), 0);
    const Expected<Solid> solid = try_solid(mesh);
    ASSERT_TRUE(solid);
    ASSERT_NO_THROW(solid->validate());
    EXPECT_EQ(solid->report.duplicates_dropped, static_cast<std::uint64_t>(copies));
    EXPECT_EQ(solid->report.open_edges, 0u);
    EXPECT_EQ(solid->report.volume, 1);
  }
}

TEST(Duplicates, TheCommonWallOfTwoTouchingCubesStaysAndTheyAreTwoParts) {
  const Expected<Solid> solid = try_solid(two_cubes_sharing_a_face(), kStrict);
  ASSERT_TRUE(solid) << solid.error().detail;
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.duplicates_dropped, 0u);
  ASSERT_EQ(solid->parts.size(), 2u);
  EXPECT_EQ(solid->parts[0].volume, 1);
  EXPECT_EQ(solid->parts[1].volume, 1);
}

TEST(Nonmanifold, CubesThatShareAnEdgeOrAVertexComeApart) {
  for (const Mesh& mesh : {two_cubes_sharing_an_edge(), two_cubes_sharing_a_vertex()}) {
    const Expected<Solid> solid = try_solid(mesh, kStrict);
    ASSERT_TRUE(solid);
    ASSERT_NO_THROW(solid->validate());
    EXPECT_EQ(solid->positions.size(), 16u);
    EXPECT_EQ(solid->edge_vertices.size(), 36u);
    EXPECT_EQ(solid->parts.size(), 2u);
    EXPECT_EQ(solid->report.volume, 2);
  }
}

TEST(Nonmanifold, WedgesOfMaterialAroundAnEdgeArePairedWithoutCrossing) {
  // A pinwheel of n tetrahedra around one edge. 2 n triangles meet there, and each wedge is a separate part.
  for (int n = 2; n <= 9; ++n) {
    std::vector<Mesh> wedges;
    for (int i = 0; i < n; ++i) {
      const CirclePoint a = circle_point(2 * i, 2 * n), b = circle_point(2 * i + 1, 2 * n);
      Mesh wedge;
      wedge.positions = {{0, 0, 0},
                         {0, 0, 1},
                         {static_cast<float>(a.cos), static_cast<float>(a.sin), 0.5f},
                         {static_cast<float>(b.cos), static_cast<float>(b.sin), 0.5f}};
      wedge.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
      if (volume_of(wedge) < 0) wedge = reversed(wedge);
      wedges.push_back(wedge);
    }
    const Expected<Solid> solid = try_solid(joined(wedges), kStrict);
    ASSERT_TRUE(solid);
    ASSERT_NO_THROW(solid->validate());
    EXPECT_EQ(solid->parts.size(), static_cast<std::size_t>(n));
    for (const Part& part : solid->parts) EXPECT_NEAR(part.volume, volume_of(wedges[0]), 1e-6);
  }
}

TEST(TolerantWeld, ClosesASurfaceWhoseVerticesDifferInTheLastBits) {
  Mesh mesh = unindexed(sphere_with(500));
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3)
    mesh.positions[i].x = std::nextafter(mesh.positions[i].x, 2.0f);
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_GT(solid->report.welded_tolerant, 0u);
  EXPECT_EQ(solid->report.open_edges, 0u);
  EXPECT_EQ(solid->parts.size(), 1u);
  EXPECT_NEAR(solid->report.volume, volume_of(sphere_with(500)), 1e-5);
}

TEST(TolerantWeld, LeavesVerticesApartThatCloseNothing) {
  // A closed cube of size 1 next to a closed cube of size 1e-7. There are no open edges, so there is nothing
  // to weld.
  const Expected<Solid> solid =
      try_solid(joined({cube(), translated(scaled(cube(), {0x1p-24, 0x1p-24, 0x1p-24}), {0, 0, 0})}));
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->report.welded_tolerant, 0u);
  EXPECT_EQ(solid->report.shells, 2u);
}

TEST(TolerantWeld, IsOffAtToleranceZeroAndInStrictMode) {
  Mesh mesh = unindexed(cube());
  mesh.positions[0].x = std::nextafter(mesh.positions[0].x, 2.0f);
  EXPECT_FALSE(try_solid(mesh, kStrict));
  EXPECT_EQ(try_solid(mesh, {.repair = Repair::kFill, .weld_tolerance = 0})->report.welded_tolerant, 0u);
  EXPECT_EQ(try_solid(mesh)->report.welded_tolerant, 1u);
}

}  // namespace
}  // namespace fracture::test
