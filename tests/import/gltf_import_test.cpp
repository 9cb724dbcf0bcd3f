// glTF as specified: every way to describe a tetrahedron gives the same tetrahedron.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/mesh/material_library.hpp"
#include "common/mesh/source_tree.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

constexpr double kVolume = 1.0 / 6;

Mesh import_ok(const Tetrahedron& tet) {
  Expected<Mesh> mesh = import_text(tet.glb(), MeshFormat::kGlb);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
  return mesh ? std::move(*mesh) : Mesh{};
}

TEST(GltfImport, KeepsPositionsBitForBitWhenNodesDoNothing) {
  Tetrahedron tet;
  std::string odd;
  put<float>(odd, {-0.0f, 0.1f, 1e-30f, 1.0000001f, 0, 0, 0, 3.14159274f, 0, 0, 0, 16777217.0f});
  tet.binary.replace(0, 48, odd);
  const Mesh mesh = import_ok(tet);
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(std::memcmp(mesh.positions.data(), odd.data(), 48), 0);
  EXPECT_EQ(mesh.node_names, std::vector<std::string>{"tet"});
}

TEST(GltfImport, MirroredNodeKeepsOutwardWinding) {
  Tetrahedron tet;
  tet.node()["scale"] = {-2, 1, 1};
  const Mesh mesh = import_ok(tet);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 2 * kVolume);
  EXPECT_EQ(mesh.positions[1], (Vec3f{-2, 0, 0}));
}

TEST(GltfImport, ComposesTheWholeChainOfNodesInDouble) {
  Tetrahedron tet;
  // A quarter turn about z, then a translation, then a scale: (x,y,z) -> 3 * ((-y, x, z) + (10, 0, 0)).
  const double h = 0.70710678118654752440;
  tet.json["nodes"] = {{{"scale", {3, 3, 3}}, {"children", {1}}},
                       {{"translation", {10, 0, 0}}, {"children", {2}}},
                       {{"mesh", 0}, {"name", "tet"}, {"rotation", {0, 0, h, h}}}};
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.positions[0], (Vec3f{30, 0, 0}));
  EXPECT_NEAR(mesh.positions[1].x, 30, 1e-6);
  EXPECT_EQ(mesh.positions[1].y, 3);
  EXPECT_EQ(mesh.positions[2].x, 27);
  EXPECT_NEAR(signed_volume(mesh), 27 * kVolume, 1e-6);
}

TEST(GltfImport, NormalsGoByTheInverseTransposeAndStayUnit) {
  Tetrahedron tet;
  const float s = 0.70710678f;
  std::string normals;
  put<float>(normals, {s, s, 0, s, s, 0, s, s, 0, s, s, 0});
  const std::size_t accessor = tet.add_accessor(normals, 5126, 4, "VEC3");
  tet.primitive()["attributes"]["NORMAL"] = accessor;
  tet.node()["scale"] = {2, 1, -1};
  const Mesh mesh = import_ok(tet);
  // The plane x + y = 0 becomes x/2 + y = 0.
  EXPECT_NEAR(mesh.attributes.normals[0].x, 0.4472136, 1e-6);
  EXPECT_NEAR(mesh.attributes.normals[0].y, 0.8944272, 1e-6);
  EXPECT_NEAR(mesh.attributes.normals[0].z, 0, 1e-6);
  EXPECT_GT(signed_volume(mesh), 0);
}

TEST(GltfImport, OnlyTheDefaultSceneCounts) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"mesh", 0}, {"name", "other"}}, {{"mesh", 0}, {"name", "shown"}}};
  tet.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  tet.json["scene"] = 1;
  EXPECT_EQ(import_ok(tet).node_names, std::vector<std::string>{"shown"});
}

TEST(GltfImport, NodesAboveOthersAndNamedMeshesAreGroups) {
  Tetrahedron tet;
  tet.json["meshes"][0]["name"] = "shape";
  tet.json["nodes"] = {{{"name", "house"}, {"children", {1, 3}}},
                       {{"children", {2}}},  // has no name
                       {{"mesh", 0}, {"name", "pane"}},
                       {{"mesh", 0}, {"name", "shape"}}};
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.node_names, (std::vector<std::string>{"pane", "shape"}));
  EXPECT_EQ(mesh.groups, (std::vector<NodeGroup>{{"house", kNoIndex}, {"shape", 0}}));
  EXPECT_EQ(mesh.group_of_node, (std::vector<std::uint32_t>{1, 0})) << "the second has the name of its mesh";
  EXPECT_TRUE(import_ok(Tetrahedron()).group_of_node.empty());
}

TEST(GltfImport, TheTreeHasNodesWithMeshesAndThoseAboveThem) {
  Tetrahedron tet;
  tet.json["meshes"][0]["name"] = "shape";
  tet.json["nodes"] = {{{"name", "house"}, {"children", {1, 4, 5}}},
                       {{"children", {2}}},  // has no name
                       {{"mesh", 0}, {"name", "wall"}, {"children", {3}}},
                       {{"mesh", 0}, {"name", "wall"}},
                       {{"name", "bones"}},
                       {{"mesh", 0}}};
  tet.json["scenes"] = {{{"nodes", {0}}}};
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.node_names, (std::vector<std::string>{"wall", "wall", "shape"}));
  ASSERT_TRUE(mesh.source_tree);
  EXPECT_EQ(*mesh.source_tree,
            (SourceTree{{{"house", kNoIndex}, {"wall", 0}, {"wall", 1}, {"shape", 0}}, {1, 2, 3}}));
  tet.json["nodes"] = {{{"mesh", 0}, {"name", "a"}}, {{"mesh", 0}, {"name", "b"}}};
  tet.json["scenes"] = {{{"nodes", {0, 1}}}};
  EXPECT_FALSE(import_ok(tet).source_tree) << "a list";
}

TEST(GltfImport, MeshUsedByTwoNodesIsTwoSurfaces) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"mesh", 0}, {"name", "a"}},
                       {{"mesh", 0}, {"name", "b"}, {"translation", {5, 0, 0}}}};
  tet.json["scenes"] = {{{"nodes", {0, 1}}}};
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.triangles.size(), 8u);
  EXPECT_EQ(mesh.node, (std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 2 * kVolume);
}

TEST(GltfImport, StripBecomesTheSameTriangles) {
  Tetrahedron tet;
  std::string strip;
  put<std::uint16_t>(strip, {0, 2, 1, 3, 0, 2});  // the strip rule reverses every second triangle
  tet.primitive()["indices"] = tet.add_accessor(strip, 5123, 6, "SCALAR");
  tet.primitive()["mode"] = 5;
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), kVolume);
}

TEST(GltfImport, FanBecomesTriangles) {
  Tetrahedron tet;
  std::string fan;
  put<std::uint8_t>(fan, {3, 0, 1, 2, 0});  // the three faces at vertex 3
  tet.primitive()["indices"] = tet.add_accessor(fan, 5121, 5, "SCALAR");
  tet.primitive()["mode"] = 6;
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.triangles.size(), 3u);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), kVolume);  // the missing face lies in a plane through the origin
}

TEST(GltfImport, UnindexedPrimitiveUsesVerticesInOrder) {
  Tetrahedron tet;
  std::string soup;
  put<float>(soup, {0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                    0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  tet.primitive() = {{"attributes", {{"POSITION", tet.add_accessor(soup, 5126, 12, "VEC3")}}}};
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.positions.size(), 12u);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), kVolume);
}

TEST(GltfImport, SparseAccessorReplacesElements) {
  Tetrahedron tet;
  std::string index, value;
  put<std::uint16_t>(index, {3});
  put<float>(value, {0, 0, 4});
  const std::size_t i = tet.add_accessor(index, 5123, 1, "SCALAR"),
                    v = tet.add_accessor(value, 5126, 1, "VEC3");
  tet.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", tet.json["accessors"][i]["bufferView"]}, {"componentType", 5123}}},
      {"values", {{"bufferView", tet.json["accessors"][v]["bufferView"]}}}};
  EXPECT_DOUBLE_EQ(signed_volume(import_ok(tet)), 4 * kVolume);
}

TEST(GltfImport, AccessorWithoutViewIsZerosPlusSparse) {
  Tetrahedron tet;
  tet.json["accessors"][0].erase("bufferView");
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.positions[3], (Vec3f{}));
}

TEST(GltfImport, NormalizedAndPlainIntegersAreDecodedAsTheQuantizationExtensionSays) {
  Tetrahedron tet;
  std::string shorts;  // four components of padding: byteStride 8
  put<std::int16_t>(shorts, {0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0});
  const std::size_t accessor = tet.add_accessor(shorts, 5122, 4, "VEC3", true);
  tet.json["bufferViews"].back()["byteStride"] = 8;
  tet.primitive()["attributes"]["POSITION"] = accessor;
  tet.json["extensionsRequired"] = nlohmann::json::array({"KHR_mesh_quantization"});
  Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.positions[1], (Vec3f{1, 0, 0}));
  EXPECT_EQ(mesh.positions[3], (Vec3f{0, 0, -1}));  // -32768 and -32767 are both -1
  tet.json["accessors"][accessor].erase("normalized");
  mesh = import_ok(tet);
  EXPECT_EQ(mesh.positions[1], (Vec3f{32767, 0, 0}));
}

TEST(GltfImport, GpuInstancingMakesOneSurfaceForEachInstance) {
  Tetrahedron tet;
  std::string translations, scales;
  put<float>(translations, {0, 0, 0, 10, 0, 0, 20, 0, 0});
  put<float>(scales, {1, 1, 1, -1, 1, 1, 2, 2, 2});
  const std::size_t t = tet.add_accessor(translations, 5126, 3, "VEC3"),
                    s = tet.add_accessor(scales, 5126, 3, "VEC3");
  tet.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", t}, {"SCALE", s}};
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_NEAR(signed_volume(mesh), (1 + 1 + 8) * kVolume, 1e-5);
}

TEST(GltfImport, EveryAttributeIsCarriedThrough) {
  Tetrahedron tet;
  std::string uv0, uv1, color, tangent;
  put<float>(uv0, {0, 0, 0.25f, 0, 0, 0.5f, 1, 1});
  put<std::uint8_t>(uv1, {0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 255, 255, 0, 0});
  put<std::uint8_t>(color, {255, 0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 51, 51, 51, 0});
  put<float>(tangent, {1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1});
  auto& attributes = tet.primitive()["attributes"];
  attributes["TEXCOORD_0"] = tet.add_accessor(uv0, 5126, 4, "VEC2");
  attributes["TEXCOORD_1"] = tet.add_accessor(uv1, 5121, 4, "VEC2", true);
  tet.json["bufferViews"].back()["byteStride"] = 4;
  attributes["COLOR_0"] = tet.add_accessor(color, 5121, 4, "VEC3", true);
  tet.json["bufferViews"].back()["byteStride"] = 4;
  attributes["TANGENT"] = tet.add_accessor(tangent, 5126, 4, "VEC4");
  const Mesh mesh = import_ok(tet);
  ASSERT_EQ(mesh.attributes.uvs.size(), 2u);
  EXPECT_EQ(mesh.attributes.uvs[0][1], (Vec2f{0.25f, 0}));
  EXPECT_EQ(mesh.attributes.uvs[1][3], (Vec2f{1, 1}));
  EXPECT_EQ(mesh.attributes.colors[0][1], (Vec4f{0, 1, 0, 1}));
  EXPECT_FLOAT_EQ(mesh.attributes.colors[0][3].x, 0.2f);
  EXPECT_EQ(mesh.attributes.tangents[2], (Vec4f{1, 0, 0, -1}));
  EXPECT_TRUE(mesh.attributes.normals.empty());
}

TEST(GltfImport, PrimitivesThatShareAccessorsShareWedges) {
  Tetrahedron tet;
  tet.json["materials"] = {{{"name", "red"}}, {{"name", "blue"}}};
  std::string first, second;
  put<std::uint16_t>(first, {0, 2, 1, 0, 1, 3});
  put<std::uint16_t>(second, {0, 3, 2, 1, 2, 3});
  const std::size_t a = tet.add_accessor(first, 5123, 6, "SCALAR"),
                    b = tet.add_accessor(second, 5123, 6, "SCALAR");
  tet.json["meshes"][0]["primitives"] = {
      {{"attributes", {{"POSITION", 0}}}, {"indices", a}, {"material", 1}},
      {{"attributes", {{"POSITION", 0}}}, {"indices", b}, {"material", 0}}};
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.material, (std::vector<std::uint32_t>{1, 1, 0, 0}));
  EXPECT_EQ(mesh.library->materials[1]["name"], "blue");
}

TEST(GltfImport, ImagesTexturesAndMaterialsPassThroughByteForByte) {
  Tetrahedron tet;
  const std::string png = "\x89PNG\r\n\x1a\nnot really";
  const std::size_t accessor = tet.add_accessor(png, 5121, png.size(), "SCALAR");
  tet.json["images"] = {
      {{"bufferView", tet.json["accessors"][accessor]["bufferView"]}, {"mimeType", "image/png"}}};
  tet.json["accessors"].erase(accessor);
  tet.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
  tet.json["samplers"] = {{{"wrapS", 33071}}};
  const nlohmann::json material = {{"name", "wood"},
                                   {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                                   {"extensions", {{"KHR_materials_ior", {{"ior", 1.4}}}}}};
  tet.json["materials"] = nlohmann::json::array({material});
  tet.json["extensionsUsed"] = nlohmann::json::array({"KHR_materials_ior"});
  tet.json["extensionsRequired"] = nlohmann::json::array({"KHR_materials_ior"});
  tet.json["asset"]["copyright"] = "CC0";
  const Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.library->materials[0], material);
  ASSERT_EQ(mesh.library->images.size(), 1u);
  EXPECT_EQ(std::string(mesh.library->images[0].bytes.begin(), mesh.library->images[0].bytes.end()), png);
  EXPECT_EQ(mesh.library->samplers[0]["wrapS"], 33071);
  EXPECT_EQ(mesh.library->extensions_required, std::vector<std::string>{"KHR_materials_ior"});
  EXPECT_EQ(mesh.copyright, "CC0");
}

TEST(GltfImport, MissingExternalImageIsAWarningAndLeavesNoDanglingReference) {
  Tetrahedron tet;
  tet.json["images"] = {{{"uri", "../secret/wood.png"}}};
  tet.json["textures"] = {{{"source", 0}}};
  tet.json["materials"] = {
      {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"roughnessFactor", 0.5}}},
       {"normalTexture", {{"index", 0}, {"scale", 2}}}}};
  const Mesh mesh = import_ok(tet);
  EXPECT_THAT(mesh.remarks.warnings, ::testing::ElementsAre(HasSubstr("../secret/wood.png")));
  EXPECT_THAT(mesh.remarks.notes, ::testing::IsEmpty());
  EXPECT_TRUE(mesh.library->images.empty());
  EXPECT_TRUE(mesh.library->textures.empty());
  EXPECT_EQ(mesh.library->materials[0],
            (nlohmann::json{{"pbrMetallicRoughness", {{"roughnessFactor", 0.5}}}}));
}

TEST(GltfImport, DataUriBufferIsRead) {
  Tetrahedron tet;
  tet.json["buffers"][0]["uri"] =
      "data:application/octet-stream;base64,"
      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAACAAEAAAABAAMAAAADAAIAAQACAAMA";
  const Expected<Mesh> mesh = import_text(tet.json.dump(), MeshFormat::kGltf);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_DOUBLE_EQ(signed_volume(*mesh), kVolume);
}

TEST(GltfImport, FurtherPartsOfTheUploadAreTheOnlyFilesThereAre) {
  Tetrahedron tet;
  tet.json["buffers"][0]["uri"] = "my%20mesh.bin";
  const std::vector<ImportFile> files{{"my mesh.bin", bytes_of(tet.binary)}};
  const Expected<Mesh> mesh = import_text(tet.json.dump(), MeshFormat::kGltf, {}, files);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_DOUBLE_EQ(signed_volume(*mesh), kVolume);
  EXPECT_EQ(import_text(tet.json.dump(), MeshFormat::kGltf).error().code, ErrorCode::kExternalResource);
}

TEST(GltfImport, SkinInBindPoseLeavesTheMeshAlone) {
  Tetrahedron tet;
  std::string joints, weights, inverse;
  put<std::uint8_t>(joints, {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});
  put<float>(weights, {0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.25f, 0.75f, 0, 0});
  put<float>(inverse, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0,  0, 1,
                       1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, -2, 0, 1});
  auto& attributes = tet.primitive()["attributes"];
  attributes["JOINTS_0"] = tet.add_accessor(joints, 5121, 4, "VEC4");
  attributes["WEIGHTS_0"] = tet.add_accessor(weights, 5126, 4, "VEC4");
  tet.json["skins"] = {
      {{"joints", {1, 2}}, {"inverseBindMatrices", tet.add_accessor(inverse, 5126, 2, "MAT4")}}};
  tet.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}},  // ignored: the skin decides
                       {{"translation", {1, 0, 0}}, {"children", {2}}},
                       {{"translation", {0, 2, 0}}}};
  tet.json["scenes"] = {{{"nodes", {0, 1}}}};
  Mesh mesh = import_ok(tet);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_THAT(mesh.remarks.notes, ::testing::ElementsAre(HasSubstr("bind pose")));
  EXPECT_THAT(mesh.remarks.warnings, ::testing::IsEmpty());
  // If a stored pose is not the bind pose, the import takes it, as every viewer does, and reports it.
  tet.json["nodes"][2]["translation"] = {0, 4, 0};
  mesh = import_ok(tet);
  EXPECT_EQ(mesh.positions[2], (Vec3f{0, 3, 0}));
  EXPECT_EQ(mesh.positions[1], (Vec3f{1, 0, 0}));
  EXPECT_THAT(mesh.remarks.notes, ::testing::ElementsAre(HasSubstr("not the bind pose")));
}

}  // namespace
}  // namespace fracture::test
