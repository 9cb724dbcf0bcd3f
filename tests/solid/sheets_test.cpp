// Sheets: pieces of a mesh that bound no volume, which a solid keeps for its answer.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

/// A unit square next to a unit cube. The square has the triangles 0 and 1.
Mesh square_and_cube() { return joined({translated(open_quad(), {5, 0, 0}), cube()}); }

TEST(KeptSheets, AreTheSourcesTrianglesAsAnOpenSurface) {
  const Mesh mesh = square_and_cube();
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.sheets, 1u);
  EXPECT_EQ(solid->report.sheet_triangles, 2u);
  EXPECT_EQ(solid->report.sheet_area, 1);
  EXPECT_EQ(solid->report.shells_dropped, 0u);
  EXPECT_EQ(solid->report.volume, 1);
  EXPECT_EQ(solid->box.max.x, 0.5) << "the box is that of the cube";
  ASSERT_TRUE(solid->sheets);
  EXPECT_FALSE(solid->sheets->whole);
  EXPECT_EQ(solid->sheets->area, 1);
  EXPECT_EQ(solid->sheets->triangles, (std::vector<std::uint32_t>{0, 1}));
  const Solid& surface = *solid->sheets->surface;
  EXPECT_EQ(surface.positions.size(), 4u);
  EXPECT_EQ(surface.edge_vertices.size(), 5u) << "four sides and a diagonal";
  EXPECT_EQ(surface.box.max.x, box_of(mesh).max.x) << "the box contains both";
  EXPECT_EQ(surface.box.min.x, -0.5);
  for (std::size_t t = 0; t < 2; ++t) {
    EXPECT_EQ(surface.wedges[t], mesh.triangles[t]);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(surface.positions[surface.triangles[t][k]], mesh.positions[mesh.triangles[t][k]]);
      const auto [low, high] = surface.edge_vertices[surface.edges[t][k]];
      EXPECT_EQ(std::minmax(low, high),
                std::minmax(surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]));
    }
  }
}

TEST(KeptSheets, AreSaidInANoteAndNotInAWarning) {
  const Expected<Solid> solid = try_solid(square_and_cube());
  ASSERT_TRUE(solid);
  const auto& [warnings, notes] = solid->report.remarks;
  EXPECT_TRUE(warnings.empty());
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(notes[0].starts_with("1 sheet without a volume (2 of 14 triangles, the first at ("))
      << notes[0];
  EXPECT_NE(notes[0].find("fragments carry its pieces"), std::string::npos) << notes[0];
  const Expected<Solid> whole = try_solid(square_and_cube(), {.sheets = SheetsMode::kWhole});
  ASSERT_TRUE(whole && whole->sheets);
  EXPECT_TRUE(whole->sheets->whole);
  ASSERT_EQ(whole->report.remarks.notes.size(), 1u);
  EXPECT_NE(whole->report.remarks.notes[0].find("stays whole"), std::string::npos);
}

TEST(KeptSheets, HaveOneVertexForBothSides) {
  const Mesh front = open_quad();
  const Expected<Solid> solid = try_solid(joined({front, reversed(front), translated(cube(), {5, 0, 0})}));
  ASSERT_TRUE(solid && solid->sheets);
  EXPECT_EQ(solid->sheets->triangles.size(), 4u);
  EXPECT_EQ(solid->sheets->area, 2) << "both sides count";
  EXPECT_EQ(solid->sheets->surface->positions.size(), 4u);
  EXPECT_EQ(solid->sheets->surface->edge_vertices.size(), 5u) << "both sides have the same diagonal";
}

TEST(KeptSheets, KeepTheDirectionsOfTheFile) {
  // Two squares side by side that face opposite ways: a solid would turn one of them.
  const Mesh mesh =
      joined({open_quad(), reversed(translated(open_quad(), {1, 0, 0})), translated(cube(), {5, 0, 0})});
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid && solid->sheets);
  ASSERT_EQ(solid->sheets->triangles.size(), 4u);
  for (std::size_t t = 0; t < 4; ++t) EXPECT_EQ(solid->sheets->surface->wedges[t], mesh.triangles[t]);
}

TEST(KeptSheets, LeaveTheSolidAsItIsWithoutThem) {
  for (const SheetsMode mode : {SheetsMode::kAttach, SheetsMode::kWhole}) {
    const Solid kept = solid_of(square_and_cube(), {.sheets = mode}),
                dropped = solid_of(square_and_cube(), {.sheets = SheetsMode::kDrop});
    EXPECT_EQ(kept.positions, dropped.positions);
    EXPECT_EQ(kept.triangles, dropped.triangles);
    EXPECT_EQ(kept.wedges, dropped.wedges);
    EXPECT_EQ(kept.edges, dropped.edges);
    EXPECT_EQ(kept.report.volume, dropped.report.volume);
    EXPECT_FALSE(dropped.sheets);
    EXPECT_EQ(dropped.report.shells_dropped, 1u);
    EXPECT_EQ(dropped.report.sheet_area, 1) << "the report says what is missing";
    EXPECT_EQ(dropped.report.remarks.warnings.size(), 1u);
  }
}

TEST(KeptSheets, AreAbsentFromASolidWithoutSheets) {
  const Solid solid = solid_of(cube());
  EXPECT_FALSE(solid.sheets);
  EXPECT_FALSE(solid.report.to_json().contains("sheets")) << "such a report is as it was";
}

TEST(KeptSheets, TrianglesWithoutAreaAreNone) {
  Mesh mesh = cube();
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const float x : {3.0f, 4.0f, 5.0f}) mesh.positions.push_back({x, 0, 0});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.material.push_back(kNoIndex);
  mesh.node.push_back(0);
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  EXPECT_FALSE(solid->sheets);
}

TEST(SheetsAsSolids, AreAsThickAsA500thOfTheDiagonalUnlessAThicknessIsGiven) {
  const Mesh mesh = square_and_cube();
  const double diagonal = length(box_of(mesh).size());
  const Expected<Solid> solid = try_solid(mesh, {.sheets = SheetsMode::kSolid});
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->report.sheets_thickened, 1u);
  EXPECT_FALSE(solid->sheets);
  EXPECT_NEAR(solid->report.volume, 1 + diagonal / 500, 1e-6);
  const Solid given = solid_of(mesh, {.sheets = SheetsMode::kSolid, .thickness = 0.25}),
              alone = solid_of(mesh, {.thickness = 0.25});
  EXPECT_EQ(given.report.volume, 1.25);
  EXPECT_EQ(alone.report.volume, 1.25) << "a thickness alone means solid";
  EXPECT_EQ(alone.positions, given.positions);
  EXPECT_EQ(alone.triangles, given.triangles);
}

TEST(SheetsAlone, AreRefusedAndTheRefusalNamesTheRemedies) {
  for (const SheetsMode mode : {SheetsMode::kAttach, SheetsMode::kWhole, SheetsMode::kDrop}) {
    const Expected<Solid> refused = try_solid(open_quad(), {.sheets = mode});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kMeshNotClosed);
    EXPECT_NE(refused.error().detail.find("sheets=solid"), std::string::npos) << refused.error().detail;
    EXPECT_NE(refused.error().detail.find("'thickness'"), std::string::npos) << refused.error().detail;
  }
  EXPECT_TRUE(try_solid(open_quad(), {.sheets = SheetsMode::kSolid}));
}

}  // namespace
}  // namespace fracture::test
