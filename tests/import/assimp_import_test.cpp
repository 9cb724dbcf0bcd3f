// The formats that Assimp reads: order, wedges and texture coordinates as in the file. No other file is read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

// A cube with side 1 as six quads, facing outwards.
constexpr const char* kCubeObj =
    "o box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

Mesh import_ok(std::string_view text, MeshFormat format, std::span<const ImportFile> files = {}) {
  Expected<Mesh> mesh = import_text(text, format, {}, files);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
  return mesh ? std::move(*mesh) : Mesh{};
}

TEST(ObjImport, PolygonsBecomeTrianglesInTheFilesOrder) {
  const Mesh mesh = import_ok(kCubeObj, MeshFormat::kObj);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(mesh.positions.size(), 8u);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 1.0);
  EXPECT_EQ(mesh.node_names, std::vector<std::string>{"box"});
  EXPECT_TRUE(mesh.attributes.normals.empty());
  for (std::size_t t = 0; t < 2; ++t)  // the first polygon is the bottom
    for (const std::uint32_t w : mesh.triangles[t]) EXPECT_EQ(mesh.positions[w].z, 0);
}

TEST(ObjImport, TextureCoordinatesPointDownAsInGltf) {
  const Mesh mesh =
      import_ok("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n", MeshFormat::kObj);
  ASSERT_EQ(mesh.attributes.uvs.size(), 1u);
  EXPECT_EQ(mesh.attributes.uvs[0][0], (Vec2f{0, 0.75f}));
  EXPECT_EQ(mesh.attributes.uvs[0][2], (Vec2f{0, 0}));
}

TEST(ObjImport, SeamsSplitWedgesButNotPositions) {
  const Mesh mesh = import_ok(
      "v 0.1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 0.5 0.5\nf 1/1 2/2 3/3\nf 3/4 2/2 "
      "4/4\n",
      MeshFormat::kObj);
  EXPECT_EQ(mesh.positions.size(), 5u);
  std::set<std::tuple<float, float, float>> distinct;
  for (const Vec3f& p : mesh.positions) distinct.insert({p.x, p.y, p.z});
  EXPECT_EQ(distinct.size(), 4u);
}

TEST(ObjImport, MaterialSlotsSurviveWithoutTheMtlAndTakeItsColoursWithIt) {
  const std::string obj =
      std::string("mtllib box.mtl\n") +
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 3 2\nf 1 2 4\nusemtl blue\nf 1 4 3\nf 2 3 4\n";
  const std::string mtl = "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 0.8\nd 0.5\n";
  const std::vector<ImportFile> files{{"box.mtl", bytes_of(mtl)}};
  const Mesh with = import_ok(obj, MeshFormat::kObj, files);
  ASSERT_EQ(with.library->materials.size(), 2u);
  const auto& blue = with.library->materials[with.material[3]];
  EXPECT_EQ(blue["name"], "blue");
  EXPECT_EQ(blue["pbrMetallicRoughness"]["baseColorFactor"], (nlohmann::json{0.0, 0.0, 0.8, 0.5}));
  EXPECT_EQ(blue["alphaMode"], "BLEND");
  const Mesh without = import_ok(obj, MeshFormat::kObj);
  EXPECT_NE(without.material[0], without.material[3]);
}

TEST(ObjImport, NamesInLatin1BecomeUtf8) {
  const std::string mtl = "newmtl d\xe4k\nKd 1 0 0\nmap_Kd \xfc.png\n";
  const std::vector<ImportFile> files{{"a.mtl", bytes_of(mtl)}};
  std::string obj = kCubeObj;
  obj.replace(obj.find("o box"), 5, "mtllib a.mtl\no b\xf6x\nusemtl d\xe4k");
  const Mesh mesh = import_ok(obj, MeshFormat::kObj, files);
  EXPECT_EQ(mesh.node_names, std::vector<std::string>{"b\xc3\xb6x"});
  EXPECT_EQ(mesh.library->materials.at(0).at("name"), "d\xc3\xa4k");
  for (const auto* list : {&mesh.remarks.warnings, &mesh.remarks.notes})
    for (const std::string& sentence : *list) EXPECT_NO_THROW(nlohmann::json(sentence).dump());
}

TEST(ObjImport, MtlOutsideTheUploadIsNotOpened) {
  const Mesh mesh = import_ok(std::string("mtllib /etc/passwd\n") + kCubeObj, MeshFormat::kObj);
  EXPECT_EQ(mesh.triangles.size(), 12u);
}

TEST(ObjImport, IndexThatDoesNotExistIsRefused) {
  EXPECT_FALSE(import_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", MeshFormat::kObj));
  EXPECT_FALSE(import_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -9\n", MeshFormat::kObj));
}

TEST(ObjImport, NaNIsRefused) {
  const Expected<Mesh> mesh = import_text("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", MeshFormat::kObj);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kNotFinite);
}

TEST(ObjImport, Utf16WithByteOrderMarkIsRead) {
  for (const bool big : {false, true}) {
    std::string wide = big ? "\xfe\xff" : "\xff\xfe";
    for (const char c : std::string(kCubeObj)) wide += big ? std::string{'\0', c} : std::string{c, '\0'};
    EXPECT_DOUBLE_EQ(signed_volume(import_ok(wide, MeshFormat::kObj)), 1.0);
  }
}

TEST(BlendImport, DamagedZstandardIsRefused) {
  const Expected<Mesh> mesh = import_text("\x28\xb5\x2f\xfd" + std::string(100, 'x'), MeshFormat::kBlend);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(mesh.error().detail, HasSubstr("damaged"));
}

TEST(BlendImport, DamagedGzipIsRefused) {
  const Expected<Mesh> mesh = import_text("\x1f\x8b" + std::string(100, 'x'), MeshFormat::kBlend);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kMalformedMesh);
}

}  // namespace
}  // namespace fracture::test
