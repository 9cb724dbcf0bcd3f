// PLY: text and binary, any properties, and what programs write into it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "common/mesh/material_library.hpp"
#include "tests/import/own_readers.hpp"

namespace fracture::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kPlyXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kPlyList = "property list uchar int vertex_indices\n";
/// The three coordinates with another type.
std::string with_type(const std::string& type) {
  return "property " + type + " x\nproperty " + type + " y\nproperty " + type + " z\n";
}
/// Four corners of a square in the plane z = 0.
const std::string kPlySquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

std::string ply_text(const std::string& vertex, const std::string& face, const std::string& data,
                     int vertices = 4, int faces = 1) {
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertices) + "\n" + vertex +
         "element face " + std::to_string(faces) + "\n" + face + "end_header\n" + data;
}

/// The binary cube of own_readers.hpp. `first`: the first coordinate.
std::string ply_cube(bool big, const std::string& line_end, float first = 0) {
  std::string ply = with_line_ends("ply\nformat binary_" + std::string(big ? "big" : "little") +
                                       "_endian 1.0\nelement vertex 8\n" + kPlyXyz + "element face 12\n" +
                                       kPlyList + "end_header\n",
                                   line_end);
  auto corners = kCubeCorners;
  corners[0][0] = first;
  for (const auto& corner : corners)
    for (const float c : corner) big ? put_big<float>(ply, {c}) : put<float>(ply, {c});
  for (const auto& triangle : kCubeTriangles) {
    ply += '\3';
    for (const int v : triangle) big ? put_big<std::int32_t>(ply, {v}) : put<std::int32_t>(ply, {v});
  }
  return ply;
}

TEST(PlyImport, ReadsColoursAndQuads) {
  const Mesh mesh = must_import(
      ply_text(kPlyXyz + "property uchar red\nproperty uchar green\nproperty uchar blue\n", kPlyList,
               "0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0 0 0 255\n0 1 0 255 255 255\n4 0 1 2 3\n"),
      MeshFormat::kPly);
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
  ASSERT_EQ(mesh.attributes.colors.size(), 1u);
  EXPECT_EQ(mesh.attributes.colors[0][0], (Vec4f{1, 0, 0, 1}));
  EXPECT_THAT(mesh.node_names, ElementsAre("mesh"));
  EXPECT_EQ(mesh.library->materials.at(0),
            nlohmann::json::parse(R"({"doubleSided": true, "pbrMetallicRoughness":
              {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0}})"));
  EXPECT_THAT(mesh.dropped, IsEmpty());
}

// Its count says nothing about the file, because such vertices have no bytes.
TEST(PlyImport, AVertexElementWithoutPropertiesHasNoVertices) {
  const Error error = must_refuse("ply\nformat ascii 1.0\nelement vertex 1000000000\nelement face 1\n" +
                                      kPlyList + "end_header\n3 0 1 2\n",
                                  MeshFormat::kPly);
  EXPECT_EQ(error.code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(error.detail, HasSubstr("names vertex 0; the file has 0 vertices"));
}

TEST(PlyImport, DataMayBeginWithALineEnd) {
  // A line feed or carriage return as the lowest byte of the first coordinate changes it by 1e-44.
  for (const char byte : {'\n', '\r', '\0'})
    for (const bool big : {false, true})
      for (const char* end : {"\n", "\r\n", "\r"}) {
        const float first = std::bit_cast<float>(big ? static_cast<std::uint32_t>(byte) << 24
                                                     : static_cast<std::uint32_t>(byte));
        EXPECT_LT(first, 1e-30f);
        const Mesh mesh = must_import(ply_cube(big, end, first), MeshFormat::kPly);
        ASSERT_EQ(mesh.triangles.size(), 12u) << int{byte} << big << with_line_ends(end, "n");
        EXPECT_EQ(mesh.positions[0].x, first);
        EXPECT_NEAR(signed_volume(mesh), 1, 1e-6);
      }
}

TEST(PlyImport, PropertiesMayHaveAnyTypeAndOrder) {
  std::string ply =
      "ply\nformat binary_big_endian 1.0\nobj_info made by hand\nelement camera 1\nproperty list ushort double "
      "view\nproperty short id\nelement face 2\nproperty uchar flags\nproperty list uint ushort vertex_index\n"
      "comment between\nelement vertex 4\nproperty double z\nproperty list uchar uchar tags\nproperty short x\n"
      "property int8 y\nthis line is not in the specification\nend_header\n";
  put_big<std::uint16_t>(ply, {2});
  put_big<double>(ply, {1.5, 2.5});
  put_big<std::int16_t>(ply, {7});
  for (const auto& face : {std::array{0, 1, 2}, std::array{2, 1, 3}}) {
    ply += '\1';
    put_big<std::uint32_t>(ply, {3});
    for (const int v : face) put_big<std::uint16_t>(ply, {static_cast<std::uint16_t>(v)});
  }
  for (int v = 0; v < 4; ++v) {
    put_big<double>(ply, {0.1 * v});
    ply += std::string(1, static_cast<char>(v)) + std::string(static_cast<std::size_t>(v), 'x');
    put_big<std::int16_t>(ply, {static_cast<std::int16_t>(-300 * v)});
    ply += static_cast<char>(-v * v);
  }
  const Mesh mesh = must_import(ply, MeshFormat::kPly);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(
      corners_of(mesh, 1),
      (std::array<Vec3f, 3>{{{-600, -4, 0.2f}, {-300, -1, 0.1f}, {-900, -9, static_cast<float>(0.1 * 3)}}}));
  EXPECT_THAT(mesh.dropped,
              ElementsAre(AllOf(Field(&Dropped::what, "element"), Field(&Dropped::name, "camera")),
                          AllOf(Field(&Dropped::what, "face property"), Field(&Dropped::name, "flags")),
                          AllOf(Field(&Dropped::what, "vertex property"), Field(&Dropped::name, "tags"))));
}

TEST(PlyImport, TextMayHaveAnyLineEndAndMoreValuesThanDeclared) {
  const std::string text =
      ply_text(kPlyXyz, kPlyList, "0 0 0 9\n1 0\n0\n\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n");
  for (const char* end : {"\n", "\r\n", "\r"}) {
    const Mesh mesh = must_import(with_line_ends(text, end), MeshFormat::kPly);
    ASSERT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(corners_of(mesh, 1), (std::array<Vec3f, 3>{{{0, 0, 0}, {1, 1, 0}, {0, 1, 0}}}));
  }
}

TEST(PlyImport, DecimalNumbersAreRoundedCorrectly) {
  const Mesh mesh =
      must_import(ply_text(kPlyXyz, kPlyList,
                           "0.1 -1.17549435e-38 16777217.5\n3.14159274 1e-50 +2\n1 1 0\n0 1 0\n3 0 1 2\n"),
                  MeshFormat::kPly);
  EXPECT_EQ(mesh.positions[0], (Vec3f{0.1f, -1.17549435e-38f, 16777218.0f}));
  EXPECT_EQ(mesh.positions[1], (Vec3f{3.14159274f, 0, 2}));
}

TEST(PlyImport, PointsAndLinesAreNoFaces) {
  const Mesh mesh = must_import(ply_text(kPlyXyz, kPlyList, kPlySquare + "0\n1 0\n2 0 1\n3 0 1 2\n", 4, 4),
                                MeshFormat::kPly);
  EXPECT_EQ(mesh.triangles.size(), 1u);
}

TEST(PlyImport, AFlatPolygonWithAReflexCornerIsNotFolded) {
  // An L of area 3. The fan from its first corner would leave it.
  const Mesh mesh =
      must_import(ply_text(kPlyXyz, kPlyList, "2 1 0\n1 1 0\n1 2 0\n0 2 0\n0 0 0\n2 0 0\n6 0 1 2 3 4 5\n", 6),
                  MeshFormat::kPly);
  ASSERT_EQ(mesh.triangles.size(), 4u);
  double area = 0;
  for (std::size_t t = 0; t < 4; ++t) {
    const auto [a, b, c] = corners_of(mesh, t);
    const double up = cross(to_double(b) - to_double(a), to_double(c) - to_double(a)).z / 2;
    EXPECT_GE(up, 0) << t;
    area += up;
  }
  EXPECT_DOUBLE_EQ(area, 3);
}

TEST(PlyImport, StripsOfTriangles) {
  const Mesh mesh =
      must_import("ply\nformat ascii 1.0\nelement vertex 4\n" + kPlyXyz +
                      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" + kPlySquare +
                      "8 0 1 3 2 -1 0 1 2\n",
                  MeshFormat::kPly);
  EXPECT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(corners_of(mesh, 0), (std::array<Vec3f, 3>{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}));
  EXPECT_EQ(corners_of(mesh, 1), (std::array<Vec3f, 3>{{{0, 1, 0}, {1, 0, 0}, {1, 1, 0}}})) << "turned over";
  EXPECT_EQ(corners_of(mesh, 2), (std::array<Vec3f, 3>{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}}));
}

TEST(PlyImport, ColoursMayBeBytesWordsOrFloats) {
  const auto first = [](const std::string& type, const std::string& values, const std::string& alpha = "") {
    const std::string names = "property " + type + " red\nproperty " + type + " green\nproperty " + type +
                              " blue\n" + (alpha.empty() ? "" : "property uchar alpha\n");
    std::string data;
    for (const char* corner : {"0 0 0", "1 0 0", "1 1 0"})
      data += corner + (" " + values) + " " + alpha + "\n";
    const Mesh mesh =
        must_import(ply_text(kPlyXyz + names, kPlyList, data + "3 0 1 2\n", 3), MeshFormat::kPly);
    return mesh.attributes.colors.empty() ? Vec4f{} : mesh.attributes.colors[0][0];
  };
  EXPECT_EQ(first("uchar", "255 0 51"), (Vec4f{1, 0, 0.2f, 1}));
  EXPECT_EQ(first("uint8", "255 0 51", "0"), (Vec4f{1, 0, 0.2f, 0}));
  EXPECT_EQ(first("ushort", "65535 0 13107"), (Vec4f{1, 0, 0.2f, 1}));
  EXPECT_EQ(first("float", "1 0.25 0.5"), (Vec4f{1, 0.25f, 0.5f, 1}));
  EXPECT_EQ(first("int", "255 0 51"), (Vec4f{1, 0, 0.2f, 1}));
}

TEST(PlyImport, NormalsAndTextureCoordinatesOfVertices) {
  for (const auto& [u, v] : {std::pair{"s", "t"}, std::pair{"u", "v"}, std::pair{"texture_u", "texture_v"},
                             std::pair{"tx", "ty"}}) {
    const Mesh mesh = must_import(
        ply_text(kPlyXyz + "property float nx\nproperty float ny\nproperty float nz\nproperty float " + u +
                     "\nproperty float " + v + "\n",
                 kPlyList, "0 0 0 0 0 2 0 0.25\n1 0 0 0 0 1 1 0\n1 1 0 0 0 -nan(ind) 1 1\n3 0 1 2\n", 3),
        MeshFormat::kPly);
    ASSERT_EQ(mesh.attributes.uvs.size(), 1u);
    EXPECT_EQ(mesh.attributes.uvs[0][0], (Vec2f{0, 0.75f})) << "glTF's v points down";
    EXPECT_EQ(mesh.attributes.normals, (std::vector<Vec3f>{{0, 0, 1}, {0, 0, 1}, {0, 0, 0}}));
  }
}

TEST(PlyImport, TextureCoordinatesOfCornersSplitWedges) {
  const Mesh mesh =
      must_import(ply_text(kPlyXyz, kPlyList + "property list uchar float texcoord\n",
                           kPlySquare + "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0.5 0 1 1 0 1\n", 4, 2),
                  MeshFormat::kPly);
  EXPECT_EQ(mesh.positions.size(), 5u) << "only the first corner has two pairs";
  ASSERT_EQ(mesh.attributes.uvs.size(), 1u);
  const auto uv = [&](std::size_t t, std::size_t k) { return mesh.attributes.uvs[0][mesh.triangles[t][k]]; };
  EXPECT_EQ(uv(0, 0), (Vec2f{0, 1}));
  EXPECT_EQ(uv(1, 0), (Vec2f{0.5f, 1}));
  EXPECT_EQ(mesh.triangles[0][2], mesh.triangles[1][1]);
}

TEST(PlyImport, EmptyListsOfTextureCoordinatesLeaveThoseOfTheVertices) {
  const Mesh mesh = must_import(ply_text(kPlyXyz + "property float s\nproperty float t\n",
                                         kPlyList + "property list uchar float texcoord\n",
                                         "0 0 0 0.5 1\n1 0 0 0.5 1\n1 1 0 0.5 1\n3 0 1 2 0\n", 3),
                                MeshFormat::kPly);
  ASSERT_EQ(mesh.attributes.uvs.size(), 1u);
  EXPECT_EQ(mesh.attributes.uvs[0][0], (Vec2f{0.5f, 0}));
  EXPECT_THAT(mesh.remarks.warnings, IsEmpty());
}

TEST(PlyImport, TextureFilesBecomeMaterials) {
  const std::string png("\x89PNG\r\n\x1a\n and so on");
  const std::vector<ImportFile> files{{"a b.png", bytes_of(png)}};
  std::string ply =
      ply_text(kPlyXyz, kPlyList + "property list uchar float texcoord\nproperty int texnumber\n",
               kPlySquare + "3 0 1 2 6 0 0 1 0 1 1 1\n3 0 2 3 6 0 0 1 1 0 1 0\n", 4, 2);
  ply.insert(ply.find("element"), "comment TextureFile  a b.png \ncomment TextureFile c.png\n");
  const Mesh mesh = must_import(with_line_ends(ply, "\r\n"), MeshFormat::kPly, files);
  ASSERT_EQ(mesh.library->materials.size(), 2u);
  ASSERT_EQ(mesh.library->images.size(), 1u);
  EXPECT_EQ(mesh.library->images[0].name, "a b.png");
  EXPECT_EQ(mesh.library->materials[0]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
  EXPECT_FALSE(mesh.library->materials[1]["pbrMetallicRoughness"].contains("baseColorTexture"));
  EXPECT_THAT(mesh.material, ElementsAre(1, 0));
  EXPECT_THAT(mesh.remarks.warnings, Contains(HasSubstr("\"c.png\"")));
}

TEST(PlyImport, WhatIsNotReadIsListed) {
  const Mesh mesh = must_import(
      ply_text(kPlyXyz + "property float quality\n", kPlyList + "property uchar red\nproperty uchar green\n",
               "0 0 0 1\n1 0 0 1\n1 1 0 1\n3 0 1 2 255 0\n", 3),
      MeshFormat::kPly);
  EXPECT_THAT(mesh.dropped,
              ElementsAre(AllOf(Field(&Dropped::what, "vertex property"), Field(&Dropped::name, "quality")),
                          Field(&Dropped::what, "face colours")));
}

TEST(PlyImport, IndicesThatDoNotExistAreRefusedWithFaceAndPlace) {
  const Error text =
      must_refuse(ply_text(kPlyXyz, kPlyList, kPlySquare + "3 0 1 2\n3 0 1 4\n", 4, 2), MeshFormat::kPly);
  EXPECT_EQ(text.code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(text.detail, AllOf(HasSubstr("Face 1"), HasSubstr("line 15"), HasSubstr("vertex 4"),
                                 HasSubstr("4 vertices")));
  std::string binary = ply_cube(false, "\n");
  const std::size_t face = binary.size() - 13;
  binary[face + 4] = '\xff';  // the highest byte of the first index
  EXPECT_THAT(
      must_refuse(binary, MeshFormat::kPly).detail,
      AllOf(HasSubstr("Face 11"), HasSubstr("byte " + std::to_string(face)), HasSubstr("vertex -16777213")));
}

TEST(PlyImport, OnlyUsedVerticesMustBeFinite) {
  const std::string data = "0 0 0\n1 0 0\nnan inf 0\n0 1 0\n";
  EXPECT_EQ(must_import(ply_text(kPlyXyz, kPlyList, data + "3 0 1 3\n"), MeshFormat::kPly).positions.size(),
            3u);
  const Error error = must_refuse(ply_text(kPlyXyz, kPlyList, data + "3 0 1 2\n"), MeshFormat::kPly);
  EXPECT_EQ(error.code, ErrorCode::kNotFinite);
  EXPECT_THAT(error.detail, AllOf(HasSubstr("Vertex 2"), HasSubstr("line 12")));
  EXPECT_EQ(
      must_refuse(ply_text(kPlyXyz, kPlyList, "0 0 0\n1e39 0 0\n1 1 0\n3 0 1 2\n", 3), MeshFormat::kPly).code,
      ErrorCode::kNotFinite)
      << "larger than any float";
}

TEST(PlyImport, SurveyCoordinatesKeepTheirDigits) {
  // A side of 1 m, far from the origin: the offset is the centre, rounded to multiples of 2 m.
  const Mesh mesh = must_import(
      ply_text(with_type("double"), kPlyList,
               "500000.25 30 4649776.5\n500001.25 30 4649776.5\n500001.25 31 4649777.5\n3 0 1 2\n", 3),
      MeshFormat::kPly);
  EXPECT_EQ(mesh.frame.offset, (Vec3d{500000, 30, 4649778}));
  EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{{0.25f, 0, -1.5f}, {1.25f, 0, -1.5f}, {1.25f, 1, -0.5f}}));
}

TEST(PlyImport, FilesThatWereCutShortAreRefused) {
  for (const bool big : {false, true}) {
    const std::string whole = ply_cube(big, "\n");
    for (std::size_t length = 1; length < whole.size(); ++length)
      EXPECT_EQ(must_refuse(whole.substr(0, length), MeshFormat::kPly).code, ErrorCode::kMalformedMesh)
          << length;
  }
  const std::string text = ply_text(kPlyXyz, kPlyList, kPlySquare + "4 0 1 2 3");
  EXPECT_EQ(must_import(text, MeshFormat::kPly).triangles.size(), 2u);
  for (std::size_t length = 1; length < text.size(); ++length)
    EXPECT_EQ(must_refuse(text.substr(0, length), MeshFormat::kPly).code, ErrorCode::kMalformedMesh)
        << length;
}

TEST(PlyImport, HeadersThatAreWrongAreRefusedWithTheLine) {
  const auto refusal = [](const std::string& from, const std::string& to) {
    std::string ply = ply_text(kPlyXyz, kPlyList, kPlySquare + "4 0 1 2 3\n");
    ply.replace(ply.find(from), from.size(), to);
    const Error error = must_refuse(ply, MeshFormat::kPly);
    EXPECT_EQ(error.code, ErrorCode::kMalformedMesh) << to;
    return error.detail;
  };
  EXPECT_THAT(refusal("format ascii", "format utf8"), AllOf(HasSubstr("line 2"), HasSubstr("\"utf8\"")));
  EXPECT_THAT(refusal("format ascii 1.0\n", ""), HasSubstr("no line \"format\""));
  EXPECT_THAT(refusal("vertex 4", "vertex four"), AllOf(HasSubstr("line 3"), HasSubstr("without a count")));
  EXPECT_THAT(refusal("float y", "half y"), AllOf(HasSubstr("line 5"), HasSubstr("\"half\"")));
  EXPECT_THAT(refusal("float y", "float w"), HasSubstr("x, y and z"));
  EXPECT_THAT(refusal("list uchar", "list float"),
              AllOf(HasSubstr("line 8"), HasSubstr("not a whole number")));
  EXPECT_THAT(refusal("vertex_indices", "corners"), HasSubstr("no list vertex_indices"));
  EXPECT_THAT(refusal("element face", "element vertex"), AllOf(HasSubstr("line 7"), HasSubstr("twice")));
  EXPECT_THAT(refusal("end_header", "end"), HasSubstr("end_header"));
  EXPECT_THAT(refusal("4 0 1 2 3", "-4 0 1 2 3"), AllOf(HasSubstr("length of a list"), HasSubstr("line 14")));
  EXPECT_THAT(refusal("4 0 1 2 3", "4 0 1 two 3"), HasSubstr("\"two\""));
}

TEST(PlyImport, ANegativeLengthInABinaryFileIsRefusedWithTheByte) {
  std::string ply = with_line_ends("ply\nformat binary_little_endian 1.0\nelement vertex 1\n" + kPlyXyz +
                                       "element face 1\nproperty list char int vertex_index\nend_header\n",
                                   "\n");
  put<float>(ply, {0, 0, 0});
  const std::size_t at = ply.size();
  ply += "\xff" + std::string(12, '\0');
  EXPECT_THAT(must_refuse(ply, MeshFormat::kPly).detail,
              AllOf(HasSubstr("negative length"), HasSubstr("byte " + std::to_string(at))));
}

TEST(PlyImport, ListsThatDoNotFitAreRefusedAtOnce) {
  EXPECT_THAT(
      must_refuse(ply_text(kPlyXyz, kPlyList, kPlySquare + "4000000000 0 1 2\n"), MeshFormat::kPly).detail,
      AllOf(HasSubstr("list of 4000000000 values"), HasSubstr("line 14")));
  std::string binary = ply_cube(true, "\n");
  binary[binary.size() - 13] = '\xff';  // the length of the last list
  EXPECT_THAT(must_refuse(binary, MeshFormat::kPly).detail,
              AllOf(HasSubstr("byte " + std::to_string(binary.size() - 12)), HasSubstr("needs 1020 more")));
}

TEST(PlyImport, LimitsHoldBeforeAndWhileReading) {
  ImportLimits limits;
  limits.max_triangles = 1;
  EXPECT_EQ(
      must_refuse(ply_text(kPlyXyz, kPlyList, kPlySquare + "4 0 1 2 3\n"), MeshFormat::kPly, limits).code,
      ErrorCode::kTooLarge)
      << "one face, two triangles";
  limits.max_triangles = 2;
  EXPECT_TRUE(import_text(ply_text(kPlyXyz, kPlyList, kPlySquare + "4 0 1 2 3\n"), MeshFormat::kPly, limits));
  limits.max_decoded_bytes = 4 * 12 - 1;
  EXPECT_EQ(
      must_refuse(ply_text(kPlyXyz, kPlyList, kPlySquare + "4 0 1 2 3\n"), MeshFormat::kPly, limits).code,
      ErrorCode::kTooLarge);
}

TEST(PlyImport, PointCloudsAreEmpty) {
  EXPECT_EQ(must_refuse("ply\nformat ascii 1.0\nelement vertex 1\n" + kPlyXyz + "end_header\n0 0 0\n",
                        MeshFormat::kPly)
                .code,
            ErrorCode::kEmptyMesh);
}

}  // namespace
}  // namespace fracture::test
