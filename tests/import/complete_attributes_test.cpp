#include "common/import/complete_attributes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// A unit square in the xy plane with its image upright: u along +x, v along -y.
Mesh upright_square(bool mirrored_image) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.material = {0, 0};
  mesh.node = {0, 0};
  mesh.node_names = {"square"};
  mesh.attributes.normals.assign(4, {0, 0, 1});
  mesh.attributes.uvs = {{{0, 1}, {1, 1}, {1, 0}, {0, 0}}};
  if (mirrored_image)
    for (Vec2f& uv : mesh.attributes.uvs[0]) uv.x = 1 - uv.x;
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"normalTexture", {{"index", 0}}}}};
  mesh.library = library;
  return mesh;
}

TEST(CompleteAttributes, TangentFollowsTheImageAndItsHandednessTheMirroring) {
  Mesh mesh = upright_square(false);
  complete_attributes(mesh);
  for (const Vec4f& t : mesh.attributes.tangents) EXPECT_EQ(t, (Vec4f{1, 0, 0, 1}));
  EXPECT_THAT(mesh.remarks.notes, Contains(HasSubstr("Tangents were computed")));
  EXPECT_TRUE(mesh.remarks.warnings.empty());
  mesh = upright_square(true);
  complete_attributes(mesh);
  for (const Vec4f& t : mesh.attributes.tangents) EXPECT_EQ(t, (Vec4f{-1, 0, 0, -1}));
}

TEST(CompleteAttributes, TangentsOfTheFileStay) {
  Mesh mesh = upright_square(false);
  mesh.attributes.tangents.assign(4, {0, 1, 0, -1});
  complete_attributes(mesh);
  EXPECT_EQ(mesh.attributes.tangents[0], (Vec4f{0, 1, 0, -1}));
  EXPECT_TRUE(mesh.remarks.empty());
}

TEST(CompleteAttributes, NormalsAreComputedOnlyUnderANormalMap) {
  Mesh mesh = upright_square(false);
  mesh.attributes.normals.clear();
  complete_attributes(mesh);
  EXPECT_EQ(mesh.attributes.normals, std::vector<Vec3f>(4, {0, 0, 1}));
  mesh = upright_square(false);
  mesh.attributes.normals.clear();
  mesh.material = {kNoIndex, kNoIndex};
  complete_attributes(mesh);
  EXPECT_TRUE(mesh.attributes.normals.empty());
  EXPECT_TRUE(mesh.attributes.tangents.empty());
}

TEST(CompleteAttributes, MissingTextureCoordinatesAreZeros) {
  Mesh mesh = upright_square(false);
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 2}}}}}}};
  mesh.library = library;
  complete_attributes(mesh);
  ASSERT_EQ(mesh.attributes.uvs.size(), 3u);
  EXPECT_EQ(mesh.attributes.uvs[2], std::vector<Vec2f>(4));
  EXPECT_THAT(mesh.remarks.warnings, Contains(HasSubstr("no UVs")));
}

TEST(CompleteAttributes, ColoursAreClamped) {
  Mesh mesh = upright_square(false);
  mesh.attributes.tangents.resize(4);
  mesh.attributes.colors = {{{2, -1, 0.5f, 1}, {}, {}, {}}};
  complete_attributes(mesh);
  EXPECT_EQ(mesh.attributes.colors[0][0], (Vec4f{1, 0, 0.5f, 1}));
}

}  // namespace
}  // namespace fracture::test
