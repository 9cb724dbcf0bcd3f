// The formats that Assimp reads: order, wedges and texture coordinates as in the file. No other file is read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

Mesh import_ok(std::string_view text, MeshFormat format, std::span<const ImportFile> files = {}) {
  Expected<Mesh> mesh = import_text(text, format, {}, files);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
  return mesh ? std::move(*mesh) : Mesh{};
}

TEST(StlImport, AsciiAndBinarySayTheSame) {
  const char* ascii =
      "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid "
      "t\n";
  std::string binary(80, ' ');
  put<std::uint32_t>(binary, {4});
  const float corners[4][9] = {{0, 0, 0, 0, 1, 0, 1, 0, 0},
                               {0, 0, 0, 1, 0, 0, 0, 0, 1},
                               {0, 0, 0, 0, 0, 1, 0, 1, 0},
                               {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  for (const auto& triangle : corners) {
    put<float>(binary, {0, 0, 0});
    for (const float c : triangle) put<float>(binary, {c});
    put<std::uint16_t>(binary, {0});
  }
  const Mesh a = import_ok(ascii, MeshFormat::kStl), b = import_ok(binary, MeshFormat::kStl);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.positions.size(), 4u);  // corners of facets share wedges
  EXPECT_TRUE(a.attributes.normals.empty());
  EXPECT_DOUBLE_EQ(signed_volume(a), 1.0 / 6);
}

TEST(PlyImport, ReadsColoursAndQuads) {
  const Mesh mesh = import_ok(
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0 0 0 255\n0 1 "
      "0 255 255 255\n"
      "4 0 1 2 3\n",
      MeshFormat::kPly);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  ASSERT_EQ(mesh.attributes.colors.size(), 1u);
  EXPECT_EQ(mesh.attributes.colors[0][mesh.triangles[0][0]].w, 1);
}

TEST(OffImport, ReadsPolygons) {
  const Mesh mesh = import_ok("OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
                              MeshFormat::kOff);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 1.0 / 6);
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
