#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stop_token>
#include <string>

#include "common/solid/solid.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

TEST(MakeSolid, ClosedShapesAreKeptAsTheyAre) {
  for (const NamedMesh& shape : closed_shapes()) {
    SCOPED_TRACE(shape.name);
    const Expected<Solid> solid = try_solid(shape.mesh, {.repair = Repair::kStrict});
    ASSERT_TRUE(solid) << solid.error().detail;
    ASSERT_NO_THROW(solid->validate());
    EXPECT_EQ(solid->triangles.size(), shape.mesh.triangles.size());
    EXPECT_EQ(solid->report.open_edges, 0u);
    EXPECT_EQ(solid->report.flipped, 0u);
    EXPECT_EQ(solid->report.fill_triangles, 0u);
    EXPECT_NEAR(solid->report.volume, volume_of(shape.mesh), 1e-12 * solid->report.volume);
    EXPECT_NEAR(solid->report.area, area_of(shape.mesh), 1e-12 * solid->report.area);
  }
}

TEST(MakeSolid, StatesTheVolumesOfShapesWithKnownFormulas) {
  EXPECT_EQ(try_solid(cube(4))->report.volume, 1);
  EXPECT_EQ(try_solid(cube(4))->report.area, 6);
  EXPECT_NEAR(try_solid(tetrahedron())->report.volume, 1.0 / 6, 1e-16);
  for (int level = 1; level <= 3; ++level) {
    const Expected<Solid> sponge = try_solid(menger_sponge(level));
    EXPECT_NEAR(sponge->report.volume, std::pow(20.0 / 27, level), 1e-6);
    EXPECT_NEAR(sponge->report.area, 2 * std::pow(20.0 / 9, level) + 4 * std::pow(8.0 / 9, level), 1e-5);
    EXPECT_EQ(sponge->report.nonmanifold_edges, 0u);
    EXPECT_EQ(sponge->parts.size(), 1u);
  }
}

TEST(MakeSolid, KeepsEachTriangleWithItsWedgesMaterialAndPositions) {
  Mesh mesh = cube_with_seams();
  for (std::size_t t = 0; t < mesh.material.size(); ++t) mesh.material[t] = static_cast<std::uint32_t>(t % 3);
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->positions.size(), 8u);
  EXPECT_EQ(solid->report.welded, 16u);
  ASSERT_EQ(solid->triangles.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    EXPECT_EQ(solid->wedges[t], mesh.triangles[t]);
    EXPECT_EQ(solid->material[t], mesh.material[t]);
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(solid->positions[solid->triangles[t][k]], mesh.positions[mesh.triangles[t][k]]);
  }
}

TEST(MakeSolid, WeldsPlusAndMinusZero) {
  Mesh mesh = unindexed(box({0, 0, 0}, {1, 1, 1}));
  for (std::size_t i = 0; i < mesh.positions.size(); i += 2)
    if (mesh.positions[i].x == 0) mesh.positions[i].x = -0.0f;
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->positions.size(), 8u);
  for (const Vec3f& p : solid->positions) EXPECT_FALSE(std::signbit(p.x) && p.x == 0);
}

TEST(MakeSolid, DropsUnusedVertices) {
  Mesh mesh = cube();
  mesh.positions.insert(mesh.positions.begin(), Vec3f{100, 100, 100});
  for (auto& triangle : mesh.triangles)
    for (auto& v : triangle) ++v;
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->positions.size(), 8u);
  EXPECT_EQ(solid->box.max, (Vec3d{0.5, 0.5, 0.5}));
}

TEST(MakeSolid, DropsDegenerateTrianglesWithoutOpeningAnything) {
  Mesh mesh = cube();
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({3, 2, 3});
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  EXPECT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.degenerate_dropped, 2u);
  EXPECT_EQ(solid->report.open_edges, 0u);
  EXPECT_EQ(solid->triangles.size(), 12u);
}

TEST(MakeSolid, KeepsTrianglesWithThreeCornersOnALineWhereTheyCloseTheSurface) {
  // An edge of a tetrahedron is split on one side only. A triangle of zero area closes the gap.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 0, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 4, 3}, {4, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 1, 4}};
  const Expected<Solid> solid = try_solid(mesh, {.repair = Repair::kStrict});
  ASSERT_TRUE(solid) << solid.error().detail;
  EXPECT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->triangles.size(), 6u);
  EXPECT_NEAR(solid->report.volume, 8.0 / 6, 1e-15);
}

TEST(MakeSolid, RefusesAnEmptyMesh) {
  const Expected<Solid> none = try_solid(Mesh{});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kEmptyMesh);
  Mesh degenerate;
  degenerate.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  degenerate.triangles = {{0, 1, 2}};
  EXPECT_EQ(try_solid(degenerate).error().code, ErrorCode::kEmptyMesh);
}

TEST(MakeSolid, RefusesNaNAndInfinityNamingTheVertex) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Mesh mesh = cube();
    mesh.positions[5].y = bad;
    const Expected<Solid> solid = try_solid(mesh);
    ASSERT_FALSE(solid);
    EXPECT_EQ(solid.error().code, ErrorCode::kNotFinite);
    EXPECT_EQ(solid.error().extra->at("vertex"), 5);
  }
}

TEST(MakeSolid, RefusesWhatIsTooFarNamingTheVertexAndTheLimit) {
  Mesh mesh = cube();
  mesh.positions[6].z = 1.1e11f;
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_FALSE(solid);
  EXPECT_EQ(solid.error().code, ErrorCode::kNotFinite);
  EXPECT_EQ(solid.error().extra->at("vertex"), 6);
  EXPECT_NE(solid.error().detail.find("1e11 m"), std::string::npos) << solid.error().detail;
  EXPECT_EQ(try_solid(scaled(cube(), {2.1e11, 2.1e11, 2.1e11})).error().code, ErrorCode::kNotFinite);
  EXPECT_TRUE(try_solid(scaled(cube(), {1.9e11, 1.9e11, 1.9e11})));
  Mesh unused = cube();
  unused.positions.push_back({1e13f, 0, 0});
  EXPECT_TRUE(try_solid(unused)) << "no triangle uses that vertex";
}

TEST(MakeSolid, RefusesWhatIsTooFarOnlyWithTheOffsetOfItsFrame) {
  Mesh mesh = cube();
  mesh.frame.offset = {0, -1e12, 5e10};
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_FALSE(solid);
  EXPECT_EQ(solid.error().code, ErrorCode::kNotFinite);
  EXPECT_TRUE(solid.error().extra->contains("vertex"));
  EXPECT_NE(solid.error().detail.find("from the file's origin along y"), std::string::npos)
      << solid.error().detail;
  EXPECT_NE(solid.error().detail.find("1e11 m"), std::string::npos) << solid.error().detail;
  mesh.frame.offset = {0, -9e10, 5e10};
  EXPECT_TRUE(try_solid(mesh));
}

TEST(MakeSolid, RefusesWhatIsSmallerThanFloatsAreExactNamingTheAxis) {
  for (const double size : {1e-45, 1e-40, 1e-38}) {
    const Expected<Solid> solid = try_solid(scaled(cube(), {size, size, size}));
    ASSERT_FALSE(solid) << size;
    if (solid.error().code == ErrorCode::kEmptyMesh) continue;  // all its corners are one float
    EXPECT_EQ(solid.error().code, ErrorCode::kNotFinite) << size;
    EXPECT_EQ(solid.error().extra->at("axis"), "x");
  }
  EXPECT_TRUE(try_solid(scaled(cube(), {3e-38, 3e-38, 3e-38})));
  const Expected<Solid> flat = try_solid(scaled(cube(), {1e-33, 1e-38, 1e-33}));
  ASSERT_FALSE(flat);
  EXPECT_EQ(flat.error().extra->at("axis"), "y");
}

TEST(MakeSolid, RefusesAnIndexBeyondThePositions) {
  Mesh mesh = cube();
  mesh.triangles[3][1] = 8;
  EXPECT_EQ(try_solid(mesh).error().code, ErrorCode::kMalformedMesh);
}

TEST(MakeSolid, RefusesASingleQuadWithCountsAndThePlace) {
  const Expected<Solid> solid = try_solid(open_quad());
  ASSERT_FALSE(solid);
  EXPECT_EQ(solid.error().code, ErrorCode::kMeshNotClosed);
  EXPECT_EQ(solid.error().extra->at("open_edges"), 4);
  EXPECT_EQ(solid.error().extra->at("edge").size(), 2u);
}

TEST(MakeSolid, SaysWhyAClosedMeshHasNoVolume) {
  // Two triangular loops of equal size and opposite winding, and a plate far thinner than neighbouring floats at 1 m are apart.
  const Expected<Solid> crossing = try_solid(prism_over({{-1, -1}, {1, 1}, {1, -1}, {-1, 1}})),
                        thin = try_solid(thin_plate(1e-10, 1));
  ASSERT_FALSE(crossing);
  EXPECT_EQ(crossing.error().code, ErrorCode::kMeshNotClosed);
  EXPECT_NE(crossing.error().detail.find("parts of opposite winding cancel"), std::string::npos)
      << crossing.error().detail;
  ASSERT_FALSE(thin);
  EXPECT_EQ(thin.error().code, ErrorCode::kMeshNotClosed);
  EXPECT_NE(thin.error().detail.find("thinner than the precision of its coordinates"), std::string::npos)
      << thin.error().detail;
  EXPECT_NE(try_solid(open_quad()).error().detail.find("1 piece is flat (4 open edges"), std::string::npos);
}

TEST(MakeSolid, IsInterruptedByCancellation) {
  std::stop_source source;
  source.request_stop();
  Execution execution;
  execution.stop = source.get_token();
  EXPECT_THROW((void)make_solid(std::make_shared<const Mesh>(cube()), {}, execution), Interrupted);
}

TEST(Layers, PartsWithDisjointBoxesShareOneLayerAndTouchingOnesDoNot) {
  EXPECT_EQ(try_solid(cube_field(3))->layers, 1u);
  EXPECT_EQ(try_solid(two_cubes_sharing_a_vertex())->layers, 2u);
  EXPECT_EQ(try_solid(joined({cube(), cube(2), cube(3)}))->layers, 3u);
}

TEST(SolidReport, WritesEveryFigureToJson) {
  const nlohmann::json json = try_solid(cube_without({2}))->report.to_json();
  EXPECT_EQ(json["open_edges"], 4);
  EXPECT_EQ(json["holes_filled"], 1);
  EXPECT_EQ(json["fill_triangles"], 2);
  EXPECT_EQ(json["filled_area"], 1.0);
  EXPECT_EQ(json["volume"], 1.0);
  EXPECT_EQ(json["parts"], 1);
  EXPECT_FALSE(json.contains("notes")) << "sentences are in the report of the answer or of the mesh";
  for (const char* figure : {"open_edges", "holes_filled"}) {  // the hole is the face y = -1/2
    ASSERT_EQ(json["samples"][figure].size(), 3u);
    EXPECT_EQ(json["samples"][figure][1], -0.5);
  }
  EXPECT_FALSE(json["samples"].contains("flipped"));
}

TEST(SolidValidate, NamesABrokenStatement) {
  Solid solid = *try_solid(cube());
  std::swap(solid.triangles[4][0], solid.triangles[4][1]);
  EXPECT_THROW(solid.validate(), InternalError);
  solid = *try_solid(two_cubes_sharing_an_edge());
  solid.parts[1].layer = solid.parts[0].layer;
  EXPECT_THROW(solid.validate(), InternalError);
  solid = *try_solid(cube());
  solid.parts[0].volume = 2;
  EXPECT_THROW(solid.validate(), InternalError);
}

TEST(Validate, NamesPartsThatTouchInOneLayer) {
  // Two overlapping cubes among a thousand that do not overlap.
  Mesh mesh = joined({cube_field(10), box({3.25, 3.25, 3.25}, {3.75, 3.75, 3.75})});
  Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid);
  ASSERT_EQ(solid->layers, 2u);
  ASSERT_NO_THROW(solid->validate());
  for (Part& part : solid->parts) part.layer = 0;
  try {
    solid->validate();
    FAIL() << "not found";
  } catch (const InternalError& error) {
    EXPECT_NE(std::string(error.what()).find("part 1000"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("touch in one layer"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace fracture::test
