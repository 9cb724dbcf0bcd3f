// OFF: all headers, text and binary.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/mesh/material_library.hpp"
#include "tests/import/own_readers.hpp"

namespace fracture::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The faces of a tetrahedron, facing outwards. With the corners below, its volume is 1/6.
const std::string kOffFaces = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// The file with `rest` after the coordinates of each vertex.
std::string off_text(const std::string& header, const std::string& rest = "",
                     const std::string& faces = kOffFaces) {
  std::string text = header + "\n";
  for (const char* corner : {"0 0 0", "1 0 0", "0 1 0", "0 0 1"}) text += corner + (" " + rest) + "\n";
  return text + faces;
}

TEST(OffImport, ReadsPolygons) {
  const Mesh mesh = must_import(off_text("OFF\n4 4 0"), MeshFormat::kOff);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 1.0 / 6);
  EXPECT_THAT(mesh.node_names, ElementsAre("mesh"));
  EXPECT_EQ(mesh.library->materials.at(0),
            nlohmann::json::parse(R"({"doubleSided": true, "pbrMetallicRoughness":
              {"baseColorFactor": [0.6, 0.6, 0.6, 1.0], "metallicFactor": 0}})"));
}

TEST(OffImport, HeadersAsProgramsWriteThem) {
  for (const char* header : {"OFF 4 4 6", "OFF4 4 6", "OFF # a comment\n\n# another\n4 4 # and one\n6",
                             "OFF\n4 4", "\xef\xbb\xbfOFF\n4 4 0", "nOFF 3\n4 4 6", "nOFF\n3\n4 4 6"}) {
    const std::string text = off_text(header);
    for (const char* end : {"\n", "\r\n", "\r"}) {
      const Expected<Mesh> mesh = import_text(with_line_ends(text, end), MeshFormat::kOff);
      ASSERT_TRUE(mesh) << header << ": " << mesh.error().detail;
      EXPECT_DOUBLE_EQ(signed_volume(*mesh), 1.0 / 6) << header;
    }
  }
}

TEST(OffImport, OtherHeadersAreRefused) {
  for (const char* header :
       {"GOFF\n4 4 6", "OFFX\n4 4 6", "NNOFF\n4 4 6", "COF\n4 4 6", "4 4 6", "# OFF\n4 4 6"}) {
    const Error error = must_refuse(off_text(header), MeshFormat::kOff);
    EXPECT_EQ(error.code, ErrorCode::kMalformedMesh) << header;
    EXPECT_THAT(error.detail, HasSubstr("begin with \"OFF\"")) << header;
  }
  const Error error = must_refuse(off_text("nOFF 4\n4 4 6"), MeshFormat::kOff);
  EXPECT_EQ(error.code, ErrorCode::kUnsupportedFeature);
  EXPECT_THAT(error.detail, HasSubstr("4 dimensions"));
}

TEST(OffImport, ColoursOfVerticesMayBeBytesOrFloats) {
  const auto color = [](const std::string& values) {
    const Mesh mesh = must_import(off_text("COFF\n4 4 0", values), MeshFormat::kOff);
    EXPECT_EQ(mesh.library->materials.at(0).at("pbrMetallicRoughness").at("baseColorFactor"),
              (nlohmann::json{1.0, 1.0, 1.0, 1.0}));
    return mesh.attributes.colors.empty() ? Vec4f{} : mesh.attributes.colors[0][0];
  };
  EXPECT_EQ(color("1 0.25 0 0.5"), (Vec4f{1, 0.25f, 0, 0.5f}));
  EXPECT_EQ(color("1 0.25 0"), (Vec4f{1, 0.25f, 0, 1}));
  EXPECT_EQ(color("255 51 0 0 # comment"), (Vec4f{1, 0.2f, 0, 0}));
  EXPECT_EQ(color("255 51 0"), (Vec4f{1, 0.2f, 0, 1}));
}

TEST(OffImport, ColoursByIndexAreListed) {
  const Mesh mesh = must_import(off_text("COFF\n4 4 0", "7"), MeshFormat::kOff);
  EXPECT_THAT(mesh.attributes.colors, IsEmpty());
  EXPECT_THAT(mesh.dropped, ElementsAre(AllOf(Field(&Dropped::what, "vertex colours"),
                                              Field(&Dropped::name, "4 vertices"))));
}

TEST(OffImport, NormalsColoursAndTextureCoordinatesInTheOrderOfTheSpecification) {
  const Mesh mesh = must_import(off_text("STCNOFF\n4 4 0", "0 0 4 1 0 0 0.5 0.25"), MeshFormat::kOff);
  EXPECT_EQ(mesh.attributes.normals.at(0), (Vec3f{0, 0, 1}));
  EXPECT_EQ(mesh.attributes.colors.at(0).at(0), (Vec4f{1, 0, 0, 1}));
  EXPECT_EQ(mesh.attributes.uvs.at(0).at(0), (Vec2f{0.5f, 0.75f}));
  EXPECT_EQ(
      must_import(off_text("CNOFF\n4 4 0", "0 0 4 0 1 0 1"), MeshFormat::kOff).attributes.colors.at(0).at(0),
      (Vec4f{0, 1, 0, 1}));
  EXPECT_EQ(must_import(off_text("NOFF\n4 4 0", "0 2 0"), MeshFormat::kOff).attributes.normals.at(0),
            (Vec3f{0, 1, 0}));
  EXPECT_EQ(must_import(off_text("STOFF\n4 4 0", "1 0"), MeshFormat::kOff).attributes.uvs.at(0).at(0),
            (Vec2f{1, 1}));
  EXPECT_THAT(must_refuse(off_text("STOFF\n4 4 0", "1"), MeshFormat::kOff).detail, HasSubstr("line 3"));
}

TEST(OffImport, HomogeneousCoordinatesAreDivided) {
  const Mesh mesh = must_import(off_text("4OFF\n4 4 0", "0.5"), MeshFormat::kOff);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 8.0 / 6);
  EXPECT_EQ(must_refuse(off_text("4OFF\n4 4 0", "0"), MeshFormat::kOff).code, ErrorCode::kNotFinite);
}

TEST(OffImport, ColoursOfFacesAreListedAndFacesMayHaveManyCorners) {
  const Mesh mesh = must_import(
      "OFF\n12 2 0\n0 0 0\n1 0 0\n2 0 0 # a comment\n3 0 0\n3 1 0\n3 2 0\n3 3 0\n2 3 0\n1 3 0\n0 3 0\n0 2 0\n0 1 0\n"
      "12  0 1 2 3 4 5 6 7 8 9 10 11 0.5 0.5 0.5\n3 0 1 2 # no colour\n",
      MeshFormat::kOff);
  EXPECT_EQ(mesh.triangles.size(), 11u) << "Assimp ignores faces of more than nine corners";
  EXPECT_THAT(mesh.dropped,
              ElementsAre(AllOf(Field(&Dropped::what, "face colours"), Field(&Dropped::name, "1 face"))));
}

TEST(OffImport, IndicesThatDoNotExistAreRefusedWithTheLine) {
  const Error error =
      must_refuse(off_text("OFF\n4 4 0", "", "3 0 2 1\n3 0 1 4\n3 0 3 2\n3 1 2 3\n"), MeshFormat::kOff);
  EXPECT_EQ(error.code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(error.detail, AllOf(HasSubstr("Face 1"), HasSubstr("line 8"), HasSubstr("vertex 4"),
                                  HasSubstr("4 vertices")));
  EXPECT_THAT(
      must_refuse(off_text("OFF\n4 4 0", "", "3 0 2 -1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"), MeshFormat::kOff)
          .detail,
      AllOf(HasSubstr("line 7"), HasSubstr("\"-1\"")));
}

TEST(OffImport, FacesWithMoreCornersThanFitAreRefusedAtOnce) {
  EXPECT_THAT(
      must_refuse(off_text("OFF\n4 1 0", "", "18446744073709551615 0 2 1\n"), MeshFormat::kOff).detail,
      AllOf(HasSubstr("line 7"), HasSubstr("18446744073709551615 corners")));
}

TEST(OffImport, FilesThatWereCutShortAreRefused) {
  const std::string text = off_text("OFF\n4 4 6");
  for (std::size_t length = 1; length + 1 < text.size(); ++length)
    EXPECT_EQ(must_refuse(text.substr(0, length), MeshFormat::kOff).code, ErrorCode::kMalformedMesh)
        << length;
  EXPECT_THAT(must_refuse(text.substr(0, text.rfind("3 1 2 3")), MeshFormat::kOff).detail,
              AllOf(HasSubstr("after 3 of 4 faces"), HasSubstr("cut short")));
}

TEST(OffImport, LimitsHoldBeforeAndWhileReading) {
  ImportLimits limits;
  limits.max_triangles = 3;
  EXPECT_EQ(must_refuse(off_text("OFF\n4 4 0"), MeshFormat::kOff, limits).code, ErrorCode::kTooLarge);
  const std::string square = "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
  limits.max_triangles = 1;
  EXPECT_EQ(must_refuse(square, MeshFormat::kOff, limits).code, ErrorCode::kTooLarge)
      << "one face, two triangles";
  limits.max_triangles = 2;
  EXPECT_EQ(must_import(square, MeshFormat::kOff, {}, limits).triangles.size(), 2u);
  limits.max_decoded_bytes = 47;
  EXPECT_EQ(must_refuse(square, MeshFormat::kOff, limits).code, ErrorCode::kTooLarge);
  EXPECT_EQ(must_refuse("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", MeshFormat::kOff).code, ErrorCode::kEmptyMesh);
}

/// The tetrahedron as binary OFF. `colored`: each vertex is red, and each face has a colour.
std::string off_binary(bool colored) {
  std::string off = colored ? "COFF BINARY\n" : "OFF BINARY\n";
  put_big<std::int32_t>(off, {4, 4, 6});
  for (const auto& corner :
       {std::array{0, 0, 0}, std::array{1, 0, 0}, std::array{0, 1, 0}, std::array{0, 0, 1}}) {
    for (const int c : corner) put_big<float>(off, {static_cast<float>(c)});
    if (colored) put_big<float>(off, {1, 0, 0, 1});
  }
  for (const auto& face :
       {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{0, 3, 2}, std::array{1, 2, 3}}) {
    put_big<std::int32_t>(off, {3});
    for (const int v : face) put_big<std::int32_t>(off, {v});
    put_big<std::int32_t>(off, {colored ? 4 : 0});
    if (colored) put_big<float>(off, {0, 1, 0, 1});
  }
  return off;
}

TEST(OffImport, BinaryIsRead) {
  const Mesh plain = must_import(off_binary(false), MeshFormat::kOff);
  EXPECT_DOUBLE_EQ(signed_volume(plain), 1.0 / 6);
  EXPECT_THAT(plain.dropped, IsEmpty());
  const Mesh colored = must_import(off_binary(true), MeshFormat::kOff);
  EXPECT_DOUBLE_EQ(signed_volume(colored), 1.0 / 6);
  EXPECT_EQ(colored.attributes.colors.at(0).at(0), (Vec4f{1, 0, 0, 1}));
  EXPECT_THAT(colored.dropped, ElementsAre(Field(&Dropped::name, "4 faces")));
}

TEST(OffImport, BinaryThatWasCutShortIsRefused) {
  for (const bool colored : {false, true}) {
    const std::string whole = off_binary(colored);
    for (std::size_t length = whole.find("BINARY") + 6; length < whole.size(); ++length)
      EXPECT_EQ(must_refuse(whole.substr(0, length), MeshFormat::kOff).code, ErrorCode::kMalformedMesh)
          << length;
  }
  std::string wrong = off_binary(false);
  wrong[wrong.size() - 5] = 9;  // the lowest byte of the last index
  EXPECT_THAT(must_refuse(wrong, MeshFormat::kOff).detail,
              AllOf(HasSubstr("byte " + std::to_string(wrong.size() - 20)), HasSubstr("vertex 9")));
}

}  // namespace
}  // namespace fracture::test
