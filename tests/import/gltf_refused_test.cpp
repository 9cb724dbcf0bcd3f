// glTF files that are refused: foreign addresses, numbers out of range, damaged structure, and limits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

Error import_refused(const Tetrahedron& tet) {
  const Expected<Mesh> mesh = import_text(tet.glb(), MeshFormat::kGlb);
  EXPECT_FALSE(mesh);
  return mesh ? Error{ErrorCode::kInternal, "imported", {}, {}} : mesh.error();
}

class ForeignUri : public ::testing::TestWithParam<const char*> {};

TEST_P(ForeignUri, IsRefusedByNameWhateverTheContainer) {
  Tetrahedron tet;
  tet.json["buffers"][0]["uri"] = GetParam();
  for (const MeshFormat format : {MeshFormat::kGlb, MeshFormat::kGltf}) {
    const Expected<Mesh> mesh = import_text(format == MeshFormat::kGlb ? tet.glb() : tet.json.dump(), format);
    ASSERT_FALSE(mesh);
    EXPECT_EQ(mesh.error().code, ErrorCode::kExternalResource);
    EXPECT_EQ(mesh.error().pointer, "/buffers/0/uri");
    EXPECT_THAT(mesh.error().detail, HasSubstr(GetParam()));
  }
}

INSTANTIATE_TEST_SUITE_P(Uris, ForeignUri,
                         ::testing::Values("/etc/passwd", "../x", "x.bin", "file:///etc/passwd",
                                           "http://localhost/x", "%2e%2e/x", ""));

TEST(GltfImport, UnusedBufferWithForeignUriIsRefusedToo) {
  Tetrahedron tet;
  tet.json["buffers"].push_back({{"byteLength", 4}, {"uri", "/etc/passwd"}});
  EXPECT_EQ(import_refused(tet).code, ErrorCode::kExternalResource);
}

TEST(GltfImport, AccessorCountBeyondItsViewIsRefusedBeforeAllocation) {
  for (const std::uint64_t count : {5ull, 1ull << 31, 1ull << 32, 1ull << 62, ~0ull}) {
    Tetrahedron tet;
    tet.json["accessors"][0]["count"] = count;
    const Error error = import_refused(tet);
    EXPECT_TRUE(error.code == ErrorCode::kMalformedMesh || error.code == ErrorCode::kTooLarge) << count;
    EXPECT_THAT(error.pointer, HasSubstr("/accessors/0"));
  }
}

TEST(GltfImport, OffsetsThatOverflowAreRefused) {
  for (const char* where : {"accessor", "view"})
    for (const std::uint64_t offset : {49ull, 1ull << 32, ~0ull, ~0ull - 47}) {
      Tetrahedron tet;
      (where[0] == 'a' ? tet.json["accessors"][0] : tet.json["bufferViews"][0])["byteOffset"] = offset;
      EXPECT_EQ(import_refused(tet).code, ErrorCode::kMalformedMesh) << where << " " << offset;
    }
}

TEST(GltfImport, NegativeAndFractionalNumbersAreRefused) {
  for (const nlohmann::json& bad :
       {nlohmann::json(-1), nlohmann::json(1.5), nlohmann::json("4"), nlohmann::json(nullptr)}) {
    Tetrahedron tet;
    tet.json["accessors"][0]["count"] = bad;
    EXPECT_EQ(import_refused(tet).code, ErrorCode::kMalformedMesh) << bad;
  }
}

TEST(GltfImport, IndexBeyondTheVerticesIsRefused) {
  Tetrahedron tet;
  tet.binary[48] = 4;
  const Error error = import_refused(tet);
  EXPECT_EQ(error.code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(error.detail, HasSubstr("vertex 4"));
}

TEST(GltfImport, NaNCoordinateIsRefusedNamingTheVertex) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Tetrahedron tet;
    std::memcpy(&tet.binary[2 * 12 + 4], &bad, 4);
    const Error error = import_refused(tet);
    EXPECT_EQ(error.code, ErrorCode::kNotFinite);
    EXPECT_THAT(error.detail, HasSubstr("Vertex 2"));
    EXPECT_EQ(error.extra->at("vertex"), 2);
  }
}

TEST(GltfImport, RequiredExtensionOutsideTheListIsRefusedByName) {
  Tetrahedron tet;
  tet.json["extensionsRequired"] = {"KHR_materials_unlit", "ACME_holograms"};
  const Error error = import_refused(tet);
  EXPECT_EQ(error.code, ErrorCode::kUnsupportedFeature);
  EXPECT_THAT(error.detail, HasSubstr("ACME_holograms"));
}

TEST(GltfImport, NodeCycleIsRefused) {
  Tetrahedron tet;
  tet.node()["children"] = nlohmann::json::array({0});
  EXPECT_EQ(import_refused(tet).code, ErrorCode::kMalformedMesh);
}

TEST(GltfImport, SceneWithoutTrianglesIsEmpty) {
  Tetrahedron tet;
  tet.primitive()["mode"] = 1;
  EXPECT_EQ(import_refused(tet).code, ErrorCode::kEmptyMesh);
  tet.json.erase("nodes");
  tet.json.erase("scenes");
  tet.json.erase("scene");
  EXPECT_EQ(import_refused(tet).code, ErrorCode::kEmptyMesh);
}

TEST(GltfImport, TriangleLimitCountsInstances) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}};
  tet.json["scenes"] = {{{"nodes", {0, 1}}}};
  ImportLimits limits;
  limits.max_triangles = 7;
  EXPECT_EQ(import_text(tet.glb(), MeshFormat::kGlb, limits).error().code, ErrorCode::kTooLarge);
  limits.max_triangles = 8;
  EXPECT_TRUE(import_text(tet.glb(), MeshFormat::kGlb, limits));
}

// Joints may be floats in a damaged file, so they can be negative.
TEST(GltfImport, JointsThatTheSkinLacksAreRefused) {
  for (const float joint : {-1.0f, 2.0f, 1e30f}) {
    Tetrahedron tet;
    std::string joints, weights;
    for (int vertex = 0; vertex < 4; ++vertex) {
      put<float>(joints, {joint, 0, 0, 0});
      put<float>(weights, {1, 0, 0, 0});
    }
    auto& attributes = tet.primitive()["attributes"];
    attributes["JOINTS_0"] = tet.add_accessor(joints, 5126, 4, "VEC4");
    attributes["WEIGHTS_0"] = tet.add_accessor(weights, 5126, 4, "VEC4");
    tet.json["skins"] = {{{"joints", {1, 2}}}};
    tet.json["nodes"] = {
        {{"mesh", 0}, {"skin", 0}}, {{"translation", {1, 0, 0}}}, {{"translation", {0, 2, 0}}}};
    tet.json["scenes"] = {{{"nodes", {0, 1, 2}}}};
    const Error error = import_refused(tet);
    EXPECT_EQ(error.code, ErrorCode::kMalformedMesh) << joint;
    EXPECT_THAT(error.detail, HasSubstr("the skin has only 2 joints")) << joint;
  }
}

TEST(GltfImport, SetsOfTextureCoordinatesAreLimited) {
  Tetrahedron tet;
  std::string uvs;
  put<float>(uvs, {0, 0, 1, 0, 0, 1, 1, 1});
  const std::size_t accessor = tet.add_accessor(uvs, 5126, 4, "VEC2");
  auto& attributes = tet.primitive()["attributes"];
  for (int set = 0; set < 64; ++set) attributes["TEXCOORD_" + std::to_string(set)] = accessor;
  EXPECT_EQ(import_text(tet.glb(), MeshFormat::kGlb).value().attributes.uvs.size(), 64u);
  attributes["TEXCOORD_64"] = accessor;
  EXPECT_EQ(import_refused(tet).code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace fracture::test
