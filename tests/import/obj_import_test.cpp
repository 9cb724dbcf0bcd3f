// OBJ: what its statements mean, however the text is written, and which nodes, wedges and remarks come from them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <set>
#include <tuple>

#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A cube with side 1 as six quads, facing outwards.
constexpr const char* kCubeObj =
    "o box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
/// The corners of a tetrahedron of volume 1/6.
const std::string kFourVertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
const std::string kTetrahedron = kFourVertices + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

Mesh read(std::string_view text, std::span<const ImportFile> files = {}) {
  Expected<Mesh> mesh = import_text(text, MeshFormat::kObj, {}, files);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
  return mesh ? std::move(*mesh) : Mesh{};
}

/// The corners of the triangles, three each.
std::vector<Vec3f> all_corners_of(const Mesh& mesh) {
  std::vector<Vec3f> corners;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t wedge : t) corners.push_back(mesh.positions[wedge]);
  return corners;
}

/// The name of each triangle's node.
std::vector<std::string> nodes_of(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const std::uint32_t node : mesh.node) names.push_back(mesh.node_names.at(node));
  return names;
}

/// The name of each triangle's material; empty if it has none.
std::vector<std::string> materials_of(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const std::uint32_t m : mesh.material)
    names.push_back(m == kNoIndex ? "" : mesh.library->materials.at(m).at("name").get<std::string>());
  return names;
}

TEST(ObjImport, PolygonsBecomeTrianglesInTheFilesOrder) {
  const Mesh mesh = read(kCubeObj);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(mesh.positions.size(), 8u);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 1.0);
  EXPECT_EQ(mesh.node_names, std::vector<std::string>{"box"});
  EXPECT_TRUE(mesh.attributes.normals.empty());
  for (std::size_t t = 0; t < 2; ++t)  // the first polygon is the bottom
    for (const std::uint32_t w : mesh.triangles[t]) EXPECT_EQ(mesh.positions[w].z, 0);
}

TEST(ObjImport, TextureCoordinatesPointDownAsInGltf) {
  const Mesh mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  ASSERT_EQ(mesh.attributes.uvs.size(), 1u);
  EXPECT_EQ(mesh.attributes.uvs[0][0], (Vec2f{0, 0.75f}));
  EXPECT_EQ(mesh.attributes.uvs[0][2], (Vec2f{0, 0}));
}

TEST(ObjImport, SeamsSplitWedgesButNotPositions) {
  const Mesh mesh = read(
      "v 0.1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 0.5 0.5\nf 1/1 2/2 3/3\nf 3/4 2/2 4/4\n");
  EXPECT_EQ(mesh.positions.size(), 5u);
  std::set<std::tuple<float, float, float>> distinct;
  for (const Vec3f& p : mesh.positions) distinct.insert({p.x, p.y, p.z});
  EXPECT_EQ(distinct.size(), 4u);
}

TEST(ObjImport, ValuesThatAreRepeatedUnderOtherNumbersShareWedges) {
  const Mesh mesh = read(kFourVertices + kFourVertices + "f 1 3 2\nf 5 6 4\nf 1 8 7\nf 2 3 8\n");
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 1.0 / 6);
}

TEST(ObjImport, EveryFormOfACornerIsRead) {
  const std::string values = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.25\nvn 0 0 2\n";
  for (const char* face :
       {"f 1/1/1 2/1/1 3/1/1\n", "f 1/1/+1 2/-1/-1 -1/1/1 # a comment\n", "\tf  1/1/1\t2/1/1   3/1/1  \n"}) {
    const Mesh mesh = read(values + face);
    EXPECT_THAT(all_corners_of(mesh), ElementsAre(Vec3f{0, 0, 0}, Vec3f{1, 0, 0}, Vec3f{0, 1, 0})) << face;
    ASSERT_EQ(mesh.attributes.uvs.size(), 1u) << face;
    for (const Vec2f& uv : mesh.attributes.uvs[0]) EXPECT_EQ(uv, (Vec2f{0.5f, 0.75f})) << face;
    for (const Vec3f& n : mesh.attributes.normals) EXPECT_EQ(n, (Vec3f{0, 0, 1})) << face;
  }
  const Mesh normals = read(values + "f 1//1 2//1 3//1\n");
  EXPECT_EQ(normals.attributes.normals.size(), 3u);
  EXPECT_TRUE(normals.attributes.uvs.empty());
  for (const char* face : {"f 1 2 3\n", "f 1/ 2/ 3/\n", "f 1// 2// 3//\n"}) {
    const Mesh bare = read(values + face);
    EXPECT_TRUE(bare.attributes.normals.empty() && bare.attributes.uvs.empty()) << face;
  }
}

TEST(ObjImport, NegativeNumbersCountBackFromTheirLine) {
  const Mesh mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 5\nf -3 -2 -1\n");
  EXPECT_THAT(all_corners_of(mesh), ElementsAre(Vec3f{0, 0, 0}, Vec3f{1, 0, 0}, Vec3f{0, 1, 0},
                                                Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 5}));
}

TEST(ObjImport, FacesMayUseVerticesThatFollow) {
  EXPECT_DOUBLE_EQ(signed_volume(read("f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n" + kFourVertices)), 1.0 / 6);
}

TEST(ObjImport, LinesMayEndInAnyWay) {
  const Mesh right = read(kTetrahedron);
  std::string mixed;
  std::size_t line = 0;
  for (const char c : kTetrahedron)
    mixed += c != '\n' ? std::string{c} : ++line % 3 == 0 ? "\r\n" : line % 3 == 1 ? "\r" : "\n";
  std::vector<std::string> texts{mixed, "\xef\xbb\xbf" + kTetrahedron,
                                 kTetrahedron.substr(0, kTetrahedron.size() - 1)};
  for (const char* end : {"\r", "\r\n", "\n\n", " \\\n \n", "\\\r\n\r\n", "\\\r\r"}) {
    texts.emplace_back();
    for (const char c : kTetrahedron) texts.back() += c == '\n' ? end : std::string{c};
  }
  for (const std::string& text : texts) {
    const Mesh mesh = read(text);
    EXPECT_EQ(mesh.positions, right.positions) << text;
    EXPECT_EQ(mesh.triangles, right.triangles) << text;
  }
}

TEST(ObjImport, ABackslashJoinsLinesExceptAfterAComment) {
  EXPECT_EQ(read("# C:\\temp\\\n" + kFourVertices + "f 1 \\\n 3 \\\r\n 2\nf 1 2 4\\\n\nf 1 4 3\nf 2 3 4\n")
                .triangles.size(),
            4u);
  EXPECT_EQ(
      read(kFourVertices + "f 1 3 2 # C:\\temp\\\nf 1 2 4\nf 1 \\\n4 3 # D:\\\nf 2 3 4\n").triangles.size(),
      4u)
      << "a comment after a statement";
  EXPECT_EQ(read(kFourVertices + "usemtl a#\\\nb\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").triangles.size(), 4u)
      << "# within a word begins no comment";
}

TEST(ObjImport, PositionsAreTheNearestFloats) {
  // Three of these are close to the middle between two floats: 1 + 2^-24 (below, above) and 2^24 + 1 (exactly, so to even).
  const Mesh mesh = read(
      "v 0.1 -0.3 1e-2\nv +1.00000005960464466 1.00000005960464489 16777217\nv 1E3 .5 5.\nv 1e-400 -0 1.5e-45\nf 1 2 3\nf 1 2 4\n");
  EXPECT_THAT(
      all_corners_of(mesh),
      ElementsAre(Vec3f{0.1f, -0.3f, 0.01f}, Vec3f{1, 0x1.000002p0f, 16777216}, Vec3f{1000, 0.5f, 5},
                  Vec3f{0.1f, -0.3f, 0.01f}, Vec3f{1, 0x1.000002p0f, 16777216}, Vec3f{0, -0.0f, 0x1p-149f}));
  EXPECT_EQ(std::bit_cast<std::uint32_t>(all_corners_of(mesh)[5].y), 0x80000000u);
}

TEST(ObjImport, FarPositionsAreReadRelativeToAnOffset) {
  // A tetrahedron of one metre at survey coordinates, where floats are half a metre apart. The offset is a multiple of 2 m.
  const Mesh far = read(
      "v 500000.25 30.125 4649776.5\nv 500001.25 30.125 4649776.5\nv 500000.25 31.125 4649776.5\n"
      "v 500000.25 30.125 4649777.5\nv 0 0 0\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  EXPECT_EQ(far.frame.offset, (Vec3d{500000, 30, 4649778}));
  EXPECT_EQ(all_corners_of(far)[0], (Vec3f{0.25f, 0.125f, -1.5f}));
  EXPECT_DOUBLE_EQ(signed_volume(far), 1.0 / 6);
  EXPECT_EQ(read(kTetrahedron).frame.offset, Vec3d{});
}

TEST(ObjImport, AFourthNumberDividesTheOthers) {
  EXPECT_THAT(all_corners_of(read("v 2 4 6 2\nv 1 0 0 1\nv 0 1 0\nf 1 2 3\n")),
              ElementsAre(Vec3f{1, 2, 3}, Vec3f{1, 0, 0}, Vec3f{0, 1, 0}));
}

TEST(ObjImport, ColoursFollowThePosition) {
  const Mesh mesh = read("v 0 0 0\nv 1 0 0 1 0.5 0\nv 0 1 0 0 0 1 0.25\nf 1 2 3\n");
  ASSERT_EQ(mesh.attributes.colors.size(), 1u);
  const auto color = [&](std::size_t k) { return mesh.attributes.colors[0][mesh.triangles[0][k]]; };
  EXPECT_EQ(color(0), (Vec4f{1, 1, 1, 1})) << "a vertex without a colour";
  EXPECT_EQ(color(1), (Vec4f{1, 0.5f, 0, 1}));
  EXPECT_EQ(color(2), (Vec4f{0, 0, 1, 0.25f}));
}

TEST(ObjImport, ObjectsAndGroupsAreNodes) {
  const std::string face = "f 1 2 3\n";
  EXPECT_THAT(nodes_of(read(kFourVertices + face + "o The Lid\n" + face + "o empty\ng a b\n" + face +
                            "g a b\n" + face + "g\n" + face)),
              ElementsAre("mesh", "The Lid", "a b", "a b", "mesh"));
  const Mesh again = read(kFourVertices + "o a\nf 1 2 3\no b\nf 1 2 4\no a\nf 2 3 4\ng b\nf 1 3 4\n");
  EXPECT_THAT(nodes_of(again), ElementsAre("a", "a", "b", "b"));
  EXPECT_THAT(again.node_names, ElementsAre("a", "b", "b")) << "o continues an object, and g begins one";
  EXPECT_EQ(all_corners_of(again)[3], (Vec3f{1, 0, 0})) << "the third face is the second one of a";
}

TEST(ObjImport, FiftyThousandNamedObjectsAreFiftyThousandNodes) {
  const std::size_t count = sized(5'000u, 50'000u);
  std::string text;
  for (std::size_t k = 0; k < count; ++k) {
    const std::string at = std::to_string(k);
    text += "o part_" + at + "\nusemtl m" + std::to_string(k % 100) + "\nv " + at + " 0 0\nv " + at +
            " 1 0\nv " + at + " 0 1\nf -3 -2 -1\n";
  }
  const Mesh mesh = read(text);
  EXPECT_EQ(mesh.triangles.size(), count);
  ASSERT_EQ(mesh.node_names.size(), count);
  EXPECT_EQ(mesh.node_names[count - 1], "part_" + std::to_string(count - 1));
  EXPECT_EQ(mesh.library->materials.size(), 100u);
  EXPECT_EQ(mesh.material[count - 1], 99u);
}

TEST(ObjImport, NamesInLatin1BecomeUtf8) {
  const std::string mtl = "newmtl d\xe4k\nKd 1 0 0\nmap_Kd \xfc.png\n";
  const std::vector<ImportFile> files{{"a.mtl", bytes_of(mtl)}};
  std::string obj = kCubeObj;
  obj.replace(obj.find("o box"), 5, "mtllib a.mtl\no b\xf6x\nusemtl d\xe4k");
  const Mesh mesh = read(obj, files);
  EXPECT_EQ(mesh.node_names, std::vector<std::string>{"b\xc3\xb6x"});
  EXPECT_EQ(mesh.library->materials.at(0).at("name"), "d\xc3\xa4k");
  for (const auto* list : {&mesh.remarks.warnings, &mesh.remarks.notes})
    for (const std::string& sentence : *list) EXPECT_NO_THROW(nlohmann::json(sentence).dump());
}

TEST(ObjImport, Utf16WithByteOrderMarkIsRead) {
  for (const bool big : {false, true}) {
    std::string wide = big ? "\xfe\xff" : "\xff\xfe";
    for (const char c : std::string(kCubeObj)) wide += big ? std::string{'\0', c} : std::string{c, '\0'};
    EXPECT_DOUBLE_EQ(signed_volume(read(wide)), 1.0);
  }
}

TEST(ObjImport, FacesHaveTheMaterialThatIsInUse) {
  const Mesh mesh = read(
      kFourVertices +
      "f 1 3 2\nusemtl red\nf 1 2 4\nusemtl blue paint \no b\nf 1 4 3\nusemtl\nf 1 2 3\nusemtl red\nf 2 3 4\n");
  EXPECT_THAT(materials_of(mesh), ElementsAre("", "red", "blue paint", "blue paint", "red"));
  EXPECT_THAT(mesh.remarks.warnings, IsEmpty()) << "the file names no library, so none is missing";
}

TEST(ObjImport, ElementsWithoutASurfaceAreListed) {
  const Mesh mesh =
      read(kTetrahedron +
           "l 1 2\np 3\nl 2 3 4\ncstype bezier\nsurf 0 1 0 1 1 2 3 4\nend\nf 1 2\ns off\nv 0 0 0 1 1\n");
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_THAT(mesh.dropped,
              Contains(Dropped{"line", "2 of them, the first on line 9", "only faces have a surface"}));
  EXPECT_THAT(mesh.dropped, Contains(Dropped{"point", "on line 10", "only faces have a surface"}));
  EXPECT_THAT(mesh.dropped, Contains(Dropped{"face", "on line 15", "it has fewer than three corners"}));
  ASSERT_EQ(mesh.dropped.size(), 5u);
  EXPECT_EQ(mesh.dropped[2].what, "free-form surface");
  EXPECT_EQ(mesh.dropped[4].name, "on line 17");
}

TEST(ObjImport, WrongNumbersOfTextureCoordinatesAreAWarning) {
  const Mesh mesh = read(kFourVertices + "vt 0 0\nf 1/1 2/1 3/7\nf 1/1 2/9 3/1\nf 1 2 4\n");
  EXPECT_EQ(mesh.triangles.size(), 3u);
  EXPECT_THAT(mesh.remarks.warnings,
              ElementsAre(HasSubstr("2 corners use a texture coordinate that the OBJ does not contain: "
                                    "line 7 uses number 9, but the file has only 1.")));
}

struct Wrong {
  const char* what;
  std::string text;
  ErrorCode code;
  std::vector<const char*> says;
};

TEST(ObjImport, ErrorsSayWhichLineIsWrongAndWhatToDo) {
  constexpr ErrorCode kBad = ErrorCode::kMalformedMesh, kInfinite = ErrorCode::kNotFinite;
  const std::string rest = "v 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::vector<Wrong> all{
      {"too few numbers", "v 0 0\n" + rest, kBad, {"Line 1", "three numbers", "cut off"}},
      {"a word", "# a\nv 0 x 0\n" + rest, kBad, {"Line 2", "\"x\"", "not a number"}},
      {"a decimal comma", "v 1,5 0 0\n" + rest, kBad, {"Line 1", "\"1,5\"", "decimal point"}},
      {"nan", "v nan 0 0\n" + rest, kInfinite, {"Line 1", "vertex 1", "finite"}},
      {"nan of Windows", "v 0 -nan(ind) 0\n" + rest, kInfinite, {"Line 1"}},
      {"old nan of Windows", "v 0 0 -1.#IND\n" + rest, kInfinite, {"Line 1"}},
      {"beyond doubles", "v 0 0 1e999\n" + rest, kInfinite, {"Line 1", "3.4e38"}},
      {"beyond floats", "v 0 0 1e39\n" + rest, kInfinite, {"Line 1", "3.4e38"}},
      {"w", "v 1 2 3 0\n" + rest, kInfinite, {"Line 1", "w"}},
      {"a vertex that does not exist",
       "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
       kBad,
       {"Line 4", "vertex 9", "3 vertices"}},
      {"backwards", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -9\n", kBad, {"Line 4", "\"-9\"", "3 values"}},
      {"zero", "v 0 0 0\n\nf 1 1 0/1\n", kBad, {"Line 3", "\"0/1\"", "v/t/n"}},
      {"letters", "v 0 0 0\nf 1 1 1x\n", kBad, {"Line 2", "\"1x\""}},
      {"four numbers", "v 0 0 0\nf 1 1 1/1/1/1\n", kBad, {"Line 2", "\"1/1/1/1\""}},
      {"cut off", "v 0 0 0\nf 1 1 1 \\", kBad, {"Line 2", "\"\\\""}},
      {"a normal", "v 0 0 0\nvn 1 0\nf 1 1 1\n", kBad, {"Line 2", "normal"}},
      {"a texture coordinate", "v 0 0 0\nvt\nf 1 1 1\n", kBad, {"Line 2", "texture coordinate"}},
      {"prose", "Dear Sir or Madam,\n", kBad, {"not an OBJ", "Dear Sir"}},
      {"a zero", std::string("v 0 0\0", 6), kBad, {"not an OBJ", "byte 5"}},
      {"no faces", "v 0 0 0\nv 1 0 0\nl 1 2\n", ErrorCode::kEmptyMesh, {"2 vertices", "no faces", "line"}},
      {"curved",
       "v 0 0 0\ncstype bspline\nsurf 0 1 0 1 1 1 1 1\nend\n",
       ErrorCode::kUnsupportedFeature,
       {"line 3", "polygons"}},
  };
  for (const Wrong& wrong : all) {
    const Expected<Mesh> mesh = import_text(wrong.text, MeshFormat::kObj);
    ASSERT_FALSE(mesh) << wrong.what;
    EXPECT_EQ(mesh.error().code, wrong.code) << wrong.what << ": " << mesh.error().detail;
    for (const char* words : wrong.says) EXPECT_THAT(mesh.error().detail, HasSubstr(words)) << wrong.what;
  }
}

TEST(ObjImport, WrongVerticesThatNoFaceUsesDoNoHarm) {
  EXPECT_DOUBLE_EQ(signed_volume(read(kTetrahedron + "v nan 0 0\nv x y z\nv 1e99 0 0\nv 1 1 1 0\n")),
                   1.0 / 6);
}

TEST(ObjImport, LimitsHoldBeforeMemoryIsUsed) {
  ImportLimits few;
  few.max_triangles = 3;
  const auto triangles =
      import_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2 3 4\n", MeshFormat::kObj, few);
  ASSERT_FALSE(triangles);
  EXPECT_EQ(triangles.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(
      triangles.error().detail,
      HasSubstr("line 6, the OBJ has 4 triangles; the limit is 3 triangles (server option --max-triangles"));
  ImportLimits small;
  small.max_decoded_bytes = 1000;
  std::string many;
  for (int k = 0; k < 100; ++k) many += "v 0 0 0\n";  // 24 bytes each, so the 42nd exceeds the limit
  const auto bytes = import_text(many, MeshFormat::kObj, small);
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(bytes.error().detail, HasSubstr("line 42"));
  EXPECT_THAT(bytes.error().detail, HasSubstr("the limit is 1 kB (server option --max-decoded"));
}

TEST(ObjImport, AFileCutOffAnywhereIsReadOrRefusedInWords) {
  const std::string whole =
      "mtllib a.mtl\no a\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 1\nvn 0 0 1\nusemtl m\nf 1/1/1 2//1 -1 \\\n 1\n";
  for (std::size_t length = 1; length <= whole.size(); ++length) {
    const Expected<Mesh> mesh = import_text(std::string_view(whole).substr(0, length), MeshFormat::kObj);
    EXPECT_TRUE(mesh || mesh.error().detail.size() >= 20) << length;
  }
}

}  // namespace
}  // namespace fracture::test
