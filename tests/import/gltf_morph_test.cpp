// Morph targets at rest, and views compressed by the successor of EXT_meshopt_compression.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Mesh import_at_rest(const Tetrahedron& tet) {
  Expected<Mesh> mesh = import_text(tet.glb(), MeshFormat::kGlb);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
  return mesh ? std::move(*mesh) : Mesh{};
}

std::size_t vectors(Tetrahedron& tet, std::initializer_list<float> values) {
  std::string bytes;
  put<float>(bytes, values);
  return tet.add_accessor(bytes, 5126, values.size() / 3, "VEC3");
}

/// Target 0 moves the apex (0,0,1) up by 2, and target 1 moves (1,0,0) to the right by 4.
Tetrahedron with_targets() {
  Tetrahedron tet;
  tet.primitive()["targets"] = {{{"POSITION", vectors(tet, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2})}},
                                {{"POSITION", vectors(tet, {0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0})}}};
  return tet;
}

TEST(GltfMorph, WeightsOfTheMeshAreAppliedAtRest) {
  Tetrahedron tet = with_targets();
  tet.json["meshes"][0]["weights"] = {1, 0.5};
  const Mesh mesh = import_at_rest(tet);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{{0, 0, 0}, {3, 0, 0}, {0, 1, 0}, {0, 0, 3}}));
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 1.5) << "3 x 1 x 3 / 6";
  EXPECT_THAT(mesh.remarks.notes, ElementsAre(HasSubstr("default weights")));
  EXPECT_THAT(mesh.remarks.warnings, IsEmpty());
}

TEST(GltfMorph, WeightsOfANodeReplaceThoseOfTheMesh) {
  Tetrahedron tet = with_targets();
  tet.json["meshes"][0]["weights"] = {1, 1};
  tet.json["nodes"] = {
      {{"mesh", 0}, {"weights", {0, 0.25}}}, {{"mesh", 0}}, {{"mesh", 0}, {"weights", {0, 0}}}};
  tet.json["scenes"][0]["nodes"] = {0, 1, 2};
  const Mesh mesh = import_at_rest(tet);
  ASSERT_EQ(mesh.positions.size(), 12u);
  EXPECT_EQ(mesh.positions[1], (Vec3f{2, 0, 0}));
  EXPECT_EQ(mesh.positions[3], (Vec3f{0, 0, 1}));
  EXPECT_EQ(mesh.positions[5], (Vec3f{5, 0, 0}));
  EXPECT_EQ(mesh.positions[7], (Vec3f{0, 0, 3}));
  EXPECT_EQ(mesh.positions[9], (Vec3f{1, 0, 0}));
  ASSERT_EQ(mesh.instances.size(), 3u);
  EXPECT_EQ(mesh.instances[0].mesh, kNoIndex) << "its weights give it another shape than the others have";
  EXPECT_EQ(mesh.instances[1].mesh, 0u);
}

TEST(GltfMorph, WithoutWeightsTheShapeKeepsItsBits) {
  Tetrahedron tet = with_targets();
  for (const bool zeros : {false, true}) {
    if (zeros) tet.json["meshes"][0]["weights"] = {0, 0};
    const Mesh mesh = import_at_rest(tet);
    EXPECT_EQ(std::memcmp(mesh.positions.data(), tet.binary.data(), 48), 0);
    EXPECT_THAT(mesh.remarks.notes, IsEmpty());
  }
}

TEST(GltfMorph, NormalsAndTangentsMoveAndStayUnit) {
  Tetrahedron tet;
  std::string tangents;
  put<float>(tangents, {1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1});
  tet.primitive()["attributes"]["NORMAL"] = vectors(tet, {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  tet.primitive()["attributes"]["TANGENT"] = tet.add_accessor(tangents, 5126, 4, "VEC4");
  tet.primitive()["targets"] = {{{"NORMAL", vectors(tet, {0, 3, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0})},
                                 {"TANGENT", vectors(tet, {-1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})}}};
  tet.json["meshes"][0]["weights"] = nlohmann::json::array({1});
  const Mesh mesh = import_at_rest(tet);
  EXPECT_FLOAT_EQ(mesh.attributes.normals[0].y, 0.6f) << "(0, 3, 4) / 5";
  EXPECT_FLOAT_EQ(mesh.attributes.normals[0].z, 0.8f);
  EXPECT_EQ(mesh.attributes.normals[1], (Vec3f{0, 0, 1}));
  EXPECT_EQ(mesh.attributes.tangents[0], (Vec4f{0, 1, 0, -1})) << "the handedness stays";
}

TEST(GltfMorph, TargetsMoveBeforeTheSkin) {
  Tetrahedron tet = with_targets();
  std::string joints, weights;
  put<std::uint8_t>(joints, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  put<float>(weights, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  tet.primitive()["attributes"]["JOINTS_0"] = tet.add_accessor(joints, 5121, 4, "VEC4");
  tet.primitive()["attributes"]["WEIGHTS_0"] = tet.add_accessor(weights, 5126, 4, "VEC4");
  tet.json["meshes"][0]["weights"] = {1, 0};
  tet.json["skins"] = {{{"joints", {1}}}};
  tet.node()["skin"] = 0;
  tet.json["nodes"].push_back({{"scale", {2, 2, 2}}});
  tet.json["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(import_at_rest(tet).positions[3], (Vec3f{0, 0, 6})) << "(1 + 2) * 2";
}

TEST(GltfMorph, PrimitivesThatShareVerticesMayMoveApart) {
  Tetrahedron tet = with_targets();
  auto& primitives = tet.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[1].erase("targets");
  tet.json["meshes"][0]["weights"] = {1, 0};
  const Mesh mesh = import_at_rest(tet);
  ASSERT_EQ(mesh.positions.size(), 8u);
  EXPECT_EQ(mesh.positions[3], (Vec3f{0, 0, 3}));
  EXPECT_EQ(mesh.positions[7], (Vec3f{0, 0, 1}));
}

TEST(GltfMorph, ATargetOfAnotherLengthIsNotAppliedWithAWarning) {
  Tetrahedron tet;
  tet.primitive()["targets"] = {{{"POSITION", vectors(tet, {0, 0, 9})}}};
  tet.json["meshes"][0]["weights"] = nlohmann::json::array({1});
  const Mesh mesh = import_at_rest(tet);
  EXPECT_EQ(mesh.positions[3], (Vec3f{0, 0, 1}));
  EXPECT_THAT(mesh.remarks.warnings, ElementsAre(HasSubstr("not applied")));
  EXPECT_THAT(mesh.remarks.notes, IsEmpty());
}

/// The positions as a view that is compressed by the extension. Files declare a second buffer, without data, for readers
/// without the extension.
Tetrahedron compressed(const char* extension) {
  Tetrahedron tet;
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(4, 12));
  meshopt_encodeVertexVersion(0);
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), tet.binary.data(), 4, 12));
  const std::size_t at = tet.binary.size();
  tet.binary.append(packed.begin(), packed.end());
  tet.binary.replace(0, 48, std::string(48, '\0'));
  tet.json["buffers"][0]["byteLength"] = tet.binary.size();
  tet.json["buffers"].push_back({{"byteLength", 48}});
  tet.json["bufferViews"][0] = {{"buffer", 1}, {"byteOffset", 0}, {"byteLength", 48}, {"byteStride", 12}};
  tet.json["bufferViews"][0]["extensions"][extension] = {
      {"buffer", 0},      {"byteOffset", at}, {"byteLength", packed.size()},
      {"byteStride", 12}, {"count", 4},       {"mode", "ATTRIBUTES"}};
  tet.json["extensionsUsed"] = nlohmann::json::array({extension});
  tet.json["extensionsRequired"] = nlohmann::json::array({extension});
  return tet;
}

TEST(GltfMeshopt, BothNamesOfTheCompressionAreRead) {
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const Mesh mesh = import_at_rest(compressed(extension));
    EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})) << extension;
    EXPECT_THAT(mesh.dropped, IsEmpty());
  }
}

TEST(GltfMeshopt, ANewerVersionOfTheCodecIsRefusedByItsNumber) {
  Tetrahedron tet = compressed("KHR_meshopt_compression");
  const auto at = tet.json["bufferViews"][0]["extensions"]["KHR_meshopt_compression"]["byteOffset"];
  tet.binary[at.get<std::size_t>()] = '\xa1';
  const Expected<Mesh> mesh = import_text(tet.glb(), MeshFormat::kGlb);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kUnsupportedFeature);
  EXPECT_THAT(mesh.error().detail, HasSubstr("version 1"));
}

}  // namespace
}  // namespace fracture::test
