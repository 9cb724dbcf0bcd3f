// STL: text and binary, with the deviations that programs write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "common/mesh/material_library.hpp"
#include "tests/import/own_readers.hpp"

namespace fracture::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using StlFacet = std::array<float, 9>;
/// A tetrahedron of volume 1/6 that faces outwards.
constexpr std::array<StlFacet, 4> kStlTetrahedron{{{0, 0, 0, 0, 1, 0, 1, 0, 0},
                                                   {0, 0, 0, 1, 0, 0, 0, 0, 1},
                                                   {0, 0, 0, 0, 0, 1, 0, 1, 0},
                                                   {1, 0, 0, 0, 1, 0, 0, 0, 1}}};

std::string stl_text(const std::string& name, const std::string& normal = "0 0 0") {
  std::string text = "solid" + name + "\n";
  for (const StlFacet& facet : kStlTetrahedron) {
    text += "  facet normal " + normal + "\n    outer loop\n";
    for (std::size_t k = 0; k < 9; k += 3)
      text += "      vertex " + std::to_string(facet[k]) + " " + std::to_string(facet[k + 1]) + " " +
              std::to_string(facet[k + 2]) + "\n";
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid" + name + "\n";
}

std::string stl_binary(std::string header, const std::vector<std::uint16_t>& attributes = {0, 0, 0, 0}) {
  header.resize(80, ' ');
  put<std::uint32_t>(header, {4});
  for (std::size_t k = 0; k < 4; ++k) {
    put<float>(header, {0, 0, 0});
    for (const float c : kStlTetrahedron[k]) put<float>(header, {c});
    put<std::uint16_t>(header, {attributes[k]});
  }
  return header;
}

TEST(StlImport, LongNamesAreCutAtACharacter) {
  const std::string name(999, 'a');
  const Mesh mesh = must_import(stl_text(" " + name + "\xc3\xa4z"), MeshFormat::kStl);
  EXPECT_THAT(mesh.node_names, ElementsAre(name));
}

TEST(StlImport, AsciiAndBinarySayTheSame) {
  const Mesh a = must_import(stl_text(" t"), MeshFormat::kStl);
  const Mesh b = must_import(stl_binary("made by hand"), MeshFormat::kStl);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.positions.size(), 4u);  // corners of facets share wedges
  EXPECT_TRUE(a.attributes.normals.empty());
  EXPECT_DOUBLE_EQ(signed_volume(a), 1.0 / 6);
  EXPECT_THAT(a.node_names, ElementsAre("t"));
  EXPECT_THAT(b.node_names, ElementsAre("mesh"));
  EXPECT_TRUE(a.library->materials.empty());
  EXPECT_EQ(a.material, std::vector<std::uint32_t>(4, kNoIndex));
}

TEST(StlImport, NormalsMayBeAnything) {
  for (const char* normal :
       {"-nan(ind) -nan(ind) -nan(ind)", "-1.#IND -1.#IND -1.#IND", "", "none given", "1 2", "nan nan nan 5"})
    EXPECT_DOUBLE_EQ(signed_volume(must_import(stl_text(" x", normal), MeshFormat::kStl)), 1.0 / 6) << normal;
}

TEST(StlImport, KeywordsMayHaveAnyCaseAndLinesAnyEnd) {
  std::string upper = stl_text(" Part");
  for (char& c : upper) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  EXPECT_THAT(must_import(upper, MeshFormat::kStl).node_names, ElementsAre("PART"));
  for (const char* end : {"\r\n", "\r", " \n\n", " "}) {
    const Mesh mesh = must_import(with_line_ends(stl_text(" x"), end), MeshFormat::kStl);
    EXPECT_DOUBLE_EQ(signed_volume(mesh), 1.0 / 6) << end;
    EXPECT_THAT(mesh.node_names, ElementsAre("x")) << end;
  }
  EXPECT_EQ(must_import("\xef\xbb\xbf" + stl_text(" x"), MeshFormat::kStl).triangles.size(), 4u);
}

TEST(StlImport, EachSolidIsAPartNamedAfterItsFirstWord) {
  const Mesh mesh = must_import(
      stl_text(" left half") + "solid none\nendsolid none\n" + stl_text("") + stl_text(" facet vertex"),
      MeshFormat::kStl);
  EXPECT_THAT(mesh.node_names, ElementsAre("left", "none", "mesh", "facet"));
  EXPECT_EQ(mesh.node, (std::vector<std::uint32_t>{0, 0, 0, 0, 2, 2, 2, 2, 3, 3, 3, 3}));
  EXPECT_EQ(mesh.positions.size(), 12u) << "parts do not share wedges";
}

TEST(StlImport, FacetsWithMoreCornersAreDivided) {
  const Mesh mesh = must_import(
      "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 2 2 0\nvertex 0 2 0\nendloop\n"
      "endfacet\nendsolid\n",
      MeshFormat::kStl);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(corners_of(mesh, 1), (std::array<Vec3f, 3>{{{0, 0, 0}, {2, 2, 0}, {0, 2, 0}}}));
}

TEST(StlImport, FacetsWithFewerCornersAreRefusedWithTheLine) {
  std::string text = stl_text(" x");
  text.replace(text.find("      vertex"), text.find('\n', text.find("vertex")) - text.find("      vertex"),
               "");
  const Error error = must_refuse(text, MeshFormat::kStl);
  EXPECT_EQ(error.code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(error.detail, AllOf(HasSubstr("facet at line 2"), HasSubstr("2 vertices")));
}

TEST(StlImport, WordsInsteadOfCoordinatesAreRefusedWithTheLine) {
  std::string text = stl_text(" x");
  text.replace(text.find("vertex ") + 7, 8, "0,000000");
  EXPECT_THAT(must_refuse(text, MeshFormat::kStl).detail,
              AllOf(HasSubstr("coordinate at line 4"), HasSubstr("\"0,000000\"")));
  text.replace(text.find("0,000000"), 8, "-1.#IND ");
  const Error error = must_refuse(text, MeshFormat::kStl);
  EXPECT_EQ(error.code, ErrorCode::kNotFinite);
  EXPECT_THAT(error.detail, AllOf(HasSubstr("Vertex 0"), HasSubstr("line 4")));
}

TEST(StlImport, TextThatWasCutShort) {
  const std::string text = stl_text(" x");
  const Mesh whole = must_import(text.substr(0, text.rfind("endsolid")), MeshFormat::kStl);
  EXPECT_EQ(whole.triangles.size(), 4u);
  EXPECT_THAT(whole.remarks.warnings, Contains(HasSubstr("endsolid")));
  EXPECT_THAT(must_import(text, MeshFormat::kStl).remarks.warnings, IsEmpty());
  for (std::size_t length = text.find("facet"); length < text.size(); ++length) {
    const Expected<Mesh> cut = import_text(std::string_view(text).substr(0, length), MeshFormat::kStl);
    if (cut)
      EXPECT_LE(cut->triangles.size(), 4u) << length;
    else
      EXPECT_NE(cut.error().detail, "") << length;
  }
  EXPECT_THAT(must_refuse(text.substr(0, text.rfind("vertex")), MeshFormat::kStl).detail,
              AllOf(HasSubstr("ends inside the facet"), HasSubstr("line 23")));
}

TEST(StlImport, BinaryMayBeginWithSolidAndContainFacet) {
  EXPECT_EQ(must_import(stl_binary("solid with a facet"), MeshFormat::kStl).triangles.size(), 4u);
}

TEST(StlImport, AWrongTriangleCountIsRefusedWithBoth) {
  for (const char* header : {"x", "solid with a facet"}) {
    std::string stl = stl_binary(header);
    stl[80] = 7;
    const Error error = must_refuse(stl, MeshFormat::kStl);
    EXPECT_EQ(error.code, ErrorCode::kMalformedMesh);
    EXPECT_THAT(error.detail, AllOf(HasSubstr("declares 7 triangles"), HasSubstr("434 bytes"),
                                    HasSubstr("has 284"), HasSubstr("enough for 4 triangles")));
  }
}

TEST(StlImport, BinaryCoordinatesThatAreNotFiniteAreRefusedWithTheByte) {
  std::string stl = stl_binary("x"), nan;
  put<float>(nan, {std::numeric_limits<float>::quiet_NaN()});
  stl.replace(84 + 50 + 24, 4, nan);  // x of the second corner of the second facet
  const Error error = must_refuse(stl, MeshFormat::kStl);
  EXPECT_EQ(error.code, ErrorCode::kNotFinite);
  EXPECT_THAT(error.detail, AllOf(HasSubstr("Vertex 4"), HasSubstr("byte 158")));
}

TEST(StlImport, ColoursOfFacetsAreKept) {
  // 15 bits: blue in the lowest five, then green and red. The highest bit says that there is a colour.
  const Mesh plain = must_import(stl_binary("x", {0x8000 | 31 << 10, 0x8000 | 31, 31, 0}), MeshFormat::kStl);
  ASSERT_EQ(plain.attributes.colors.size(), 1u);
  const auto color = [](const Mesh& mesh, std::size_t t) {
    return mesh.attributes.colors[0][mesh.triangles[t][0]];
  };
  EXPECT_EQ(color(plain, 0), (Vec4f{1, 0, 0, 1}));
  EXPECT_EQ(color(plain, 1), (Vec4f{0, 0, 1, 1}));
  EXPECT_EQ(color(plain, 2), (Vec4f{0.6f, 0.6f, 0.6f, 0.6f}));
  EXPECT_EQ(color(plain, 3), color(plain, 2));
  const Mesh magics =
      must_import(stl_binary("COLOR=\xff\xff\x01\xff", {0x8000 | 31 << 10, 0, 0, 0}), MeshFormat::kStl);
  EXPECT_EQ(color(magics, 0), (Vec4f{0, 0, 1, 1}));
  EXPECT_EQ(color(magics, 1).x, 1);
  EXPECT_NEAR(color(magics, 1).z, 1 / 255.0, 1e-7);
}

TEST(StlImport, TheColourOfAWholeObjectBecomesItsMaterial) {
  const Mesh mesh =
      must_import(stl_binary(std::string("made by COLOR=\xff\x33\0\xff", 18)), MeshFormat::kStl);
  EXPECT_TRUE(mesh.attributes.colors.empty());
  ASSERT_EQ(mesh.library->materials.size(), 1u);
  EXPECT_EQ(mesh.library->materials[0]["pbrMetallicRoughness"]["baseColorFactor"],
            (nlohmann::json{1.0, 0.2, 0.0, 1.0}));
  EXPECT_EQ(mesh.material, std::vector<std::uint32_t>(4, 0));
}

TEST(StlImport, AllSolidsHaveTheSameOffset) {
  std::string text;
  for (const char* x : {"4000000", "4000002"})
    text += std::string("solid\nfacet normal 0 0 1\nouter loop\nvertex ") + x + ".125 0 0\nvertex " + x +
            ".625 0 0\nvertex " + x + ".125 1 0\nendloop\nendfacet\nendsolid\n";
  const Mesh mesh = must_import(text, MeshFormat::kStl);
  // The longest side of the file is 2.5, so the offset is a multiple of 4.
  EXPECT_EQ(mesh.frame.offset, (Vec3d{4000000, 0, 0}));
  EXPECT_EQ(corners_of(mesh, 0)[1], (Vec3f{0.625f, 0, 0}));
  EXPECT_EQ(corners_of(mesh, 1)[0], (Vec3f{2.125f, 0, 0}));
}

TEST(StlImport, FilesWithoutFacetsAreEmpty) {
  for (const char* text : {"solid x\nendsolid x\n", "solid facet\nendsolid\n"})
    EXPECT_EQ(must_refuse(text, MeshFormat::kStl).code, ErrorCode::kEmptyMesh) << text;
  EXPECT_EQ(must_refuse("solid x", MeshFormat::kStl).code, ErrorCode::kMalformedMesh);
}

TEST(StlImport, TheLimitOfTrianglesHoldsForText) {
  ImportLimits limits;
  limits.max_triangles = 3;
  EXPECT_EQ(must_refuse(stl_text(" x"), MeshFormat::kStl, limits).code, ErrorCode::kTooLarge);
  limits.max_triangles = 4;
  EXPECT_EQ(must_import(stl_text(" x"), MeshFormat::kStl, {}, limits).triangles.size(), 4u);
}

}  // namespace
}  // namespace fracture::test
