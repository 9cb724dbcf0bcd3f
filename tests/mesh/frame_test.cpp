// Units and axes: lengths scale, z up becomes y up, and the report states the source of each.
#include "common/mesh/frame.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

TEST(Frame, MetresAndYUpStayBitForBit) {
  Mesh mesh = box({0.1, -0.2, 0.3}, {1, 2, 3});
  const std::vector<Vec3f> before = mesh.positions;
  const auto report = to_metres_y_up(mesh, {});
  ASSERT_TRUE(report);
  EXPECT_EQ(mesh.positions, before);
  EXPECT_EQ(report->unit_from, FrameReport::From::kAssumed);
  EXPECT_EQ(report->up_from, FrameReport::From::kAssumed);
  EXPECT_EQ(report->metres_per_unit, 1.0);
}

TEST(Frame, ABoxInEachUnitHasItsVolumeInCubicMetres) {
  const std::pair<LengthUnit, double> units[] = {{LengthUnit::kMetre, 1},
                                                 {LengthUnit::kCentimetre, 0.01},
                                                 {LengthUnit::kMillimetre, 0.001},
                                                 {LengthUnit::kInch, 0.0254},
                                                 {LengthUnit::kKilometre, 1000}};
  for (const auto& [unit, metres] : units) {
    Mesh mesh = box({0, 0, 0}, {2, 3, 4});
    const auto report = to_metres_y_up(mesh, {.unit = unit});
    ASSERT_TRUE(report);
    EXPECT_NEAR(volume_of(mesh) / (24 * metres * metres * metres), 1, 1e-6);
    EXPECT_EQ(report->unit_from, FrameReport::From::kRequest);
  }
}

TEST(Frame, ZUpIsTurnedSoThatTheTopIsTheTopAndNothingIsMirrored) {
  Mesh mesh = box({0, 0, 0}, {1, 2, 3});
  mesh.attributes.normals.assign(mesh.positions.size(), {0, 0, 1});
  mesh.attributes.tangents.assign(mesh.positions.size(), {0, 1, 0, -1});
  const auto report = to_metres_y_up(mesh, {.up = UpAxis::kZ});
  ASSERT_TRUE(report);
  float height = 0;
  for (const Vec3f& p : mesh.positions) height = std::max(height, p.y);
  EXPECT_EQ(height, 3.0f);
  EXPECT_EQ(volume_of(mesh), 6.0);
  EXPECT_EQ(mesh.attributes.normals[0], (Vec3f{0, 1, 0}));
  EXPECT_EQ(mesh.attributes.tangents[0], (Vec4f{0, 0, -1, -1}));
  for (const Vec3f& p : mesh.positions) EXPECT_FALSE(p.z == 0 && std::signbit(p.z));
  EXPECT_TRUE(report->z_up);
}

TEST(Frame, EmptyNodesMoveWithTheMeshAndKeepTheirScale) {
  Mesh mesh = cube();
  // Its axes are x, z and -y, twice as long: its z axis points down the file's y axis.
  mesh.empty_nodes = {{"socket", {2, 0, 0}, {0, 0, 2}, {0, -2, 0}, {100, 200, 300}, "\"a\":1"}};
  ASSERT_TRUE(to_metres_y_up(mesh, {.unit = LengthUnit::kCentimetre, .up = UpAxis::kZ}));
  const EmptyNode& socket = mesh.empty_nodes[0];
  EXPECT_EQ(socket.t, (Vec3d{1, 3, -2})) << "(x, z, -y) in metres";
  // The frame turns by a quarter about x, and so does the node: both turns have the same axis, so they commute.
  EXPECT_EQ(socket.x, (Vec3d{2, 0, 0}));
  EXPECT_EQ(socket.y, (Vec3d{0, 0, 2}));
  EXPECT_EQ(socket.z, (Vec3d{0, -2, 0}));
  EXPECT_EQ(socket.extras, "\"a\":1");
  // A node that stands upright on z, three times as high, stands upright on y afterwards.
  Mesh other = cube();
  other.empty_nodes = {{.name = "pole", .z = {0, 0, 3}}};
  ASSERT_TRUE(to_metres_y_up(other, {.up = UpAxis::kZ}));
  EXPECT_EQ(other.empty_nodes[0].y, (Vec3d{0, 3, 0}));
  EXPECT_EQ(other.empty_nodes[0].z, (Vec3d{0, 0, 1}));
}

// (100, 200, 300) cm with z up are 1 m to the right, 3 m up and 2 m away, which is -z.
TEST(Frame, TheOffsetIsConvertedLikeThePositionsAndStated) {
  Mesh mesh = cube();
  const std::size_t notes = mesh.remarks.notes.size();
  EXPECT_FALSE(nlohmann::json(*to_metres_y_up(mesh, {})).contains("offset")) << "near the origin";
  EXPECT_EQ(mesh.remarks.notes.size(), notes);
  mesh = cube();
  mesh.frame.offset = {100, 200, 300};
  const auto report = to_metres_y_up(mesh, {.unit = LengthUnit::kCentimetre, .up = UpAxis::kZ});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->offset, (Vec3d{1, 3, -2}));
  EXPECT_EQ(mesh.frame.offset, report->offset);
  EXPECT_EQ(nlohmann::json(*report).at("offset"), nlohmann::json({1.0, 3.0, -2.0}));
  ASSERT_EQ(mesh.remarks.notes.size(), notes + 1);
  EXPECT_NE(mesh.remarks.notes.back().find("(1, 3, -2) m"), std::string::npos) << mesh.remarks.notes.back();
  EXPECT_EQ(to_text({500000.25, -30, 4649776}), "(500000.25, -30, 4649776)");
}

TEST(Frame, TheFileIsBelievedUnlessTheRequestSaysOtherwise) {
  const SourceFrame inches_z_up{.metres = 0.0254, .metres_stated = true, .z_up = true, .up_stated = true};
  Mesh by_file = cube();
  by_file.frame = inches_z_up;
  const auto report = to_metres_y_up(by_file, {});
  EXPECT_EQ(report->metres_per_unit, 0.0254);
  EXPECT_EQ(report->unit_from, FrameReport::From::kFile);
  EXPECT_EQ(report->up_from, FrameReport::From::kFile);
  const std::vector<Vec3f> once = by_file.positions;
  EXPECT_TRUE(to_metres_y_up(by_file, {}));
  EXPECT_EQ(by_file.positions, once) << "a mesh in metres with y up is not turned again";
  Mesh by_request = cube();
  by_request.frame = inches_z_up;
  EXPECT_TRUE(to_metres_y_up(by_request, {.unit = LengthUnit::kMetre, .up = UpAxis::kY}));
  EXPECT_EQ(by_request.positions, cube().positions);
}

TEST(Frame, CoordinatesBeyondFloatAreRefusedWithTheVertex) {
  Mesh mesh = cube();
  mesh.positions[3].x = 3e38f;
  mesh.frame.metres = 10;
  const auto report = to_metres_y_up(mesh, {});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::kNotFinite);
  EXPECT_EQ(report.error().extra->at("vertex"), 3);
}

}  // namespace
}  // namespace fracture::test
