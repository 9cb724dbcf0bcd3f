// Scenes far from the origin. Floats there have steps of half a metre, so positions are exact only below the offset.
#include <gtest/gtest.h>

#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

const Vec3d kFar{500000, 30, 4649776};  // a UTM easting, a height and a northing
const json kFarJson = {500000, 30, 4649776};
/// The corners of Tetrahedron.
const std::vector<Vec3f> kCorners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

Mesh imported(const Tetrahedron& tet) {
  Expected<Mesh> mesh = import_text(tet.glb(), MeshFormat::kGlb);
  if (!mesh) throw std::runtime_error(mesh.error().detail);
  return std::move(*mesh);
}

// The box has a side of 1 m, so offsets are multiples of 2 m: kFar is the multiple that is nearest to its centre.
TEST(GltfOffset, AFarNodeIsTheOffsetAndNoPositionIsRounded) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"translation", kFarJson}, {"children", {1}}}, {{"mesh", 0}, {"name", "tet"}}};
  for (const bool stated : {false, true}) {
    if (stated) {
      tet.json["accessors"][0]["min"] = {0, 0, 0};
      tet.json["accessors"][0]["max"] = {1, 1, 1};
    }
    const Mesh mesh = imported(tet);
    EXPECT_EQ(mesh.positions, kCorners);
    EXPECT_EQ(mesh.frame.offset, kFar);
  }
}

TEST(FileOffset, TextThatIsFarAwayHasTheSameOffset) {
  const Expected<Mesh> mesh = import_text(
      "v 500000 30 4649776\nv 500001 30 4649776\nv 500000 31 4649776\nv 500000 30 4649777\n"
      "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
      MeshFormat::kObj);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->frame.offset, kFar);
  EXPECT_EQ(signed_volume(*mesh), 1.0 / 6);
}

TEST(GltfOffset, OneOffsetServesAllNodesAndInstances) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"mesh", 0}, {"translation", {500000, 30, 4649776}}},
                       {{"mesh", 0}, {"translation", {500000.5, 30, 4649776}}}};
  tet.json["scenes"] = {{{"nodes", {0, 1}}}};
  Mesh mesh = imported(tet);
  EXPECT_EQ(mesh.frame.offset, kFar);
  EXPECT_EQ(mesh.positions[4], (Vec3f{0.5, 0, 0}));

  std::string translations;
  put<float>(translations, {0, 0, 0, 0.25f, 0, 0});
  tet.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      tet.add_accessor(translations, 5126, 2, "VEC3");
  mesh = imported(tet);
  EXPECT_EQ(mesh.positions[4], (Vec3f{0.25, 0, 0}));
  EXPECT_EQ(mesh.positions[8], (Vec3f{0.5, 0, 0}));
}

TEST(GltfOffset, NearTheOriginNothingIsSubtracted) {
  Tetrahedron tet;
  tet.node()["translation"] = {10.1, 0, -7.3};
  const Mesh mesh = imported(tet);
  EXPECT_EQ(mesh.frame.offset, Vec3d{});
  EXPECT_EQ(mesh.positions[0], (Vec3f{10.1f, 0, -7.3f}));
}

/// Two joints below the first node; the mesh's own node is ignored.
Tetrahedron skinned(double raised) {
  Tetrahedron tet;
  std::string joints, weights, inverse;
  put<std::uint8_t>(joints, {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});
  put<float>(weights, {1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0});  // the last vertex has no weight
  put<float>(inverse, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0,  0, 1,
                       1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, -2, 0, 1});
  auto& attributes = tet.primitive()["attributes"];
  attributes["JOINTS_0"] = tet.add_accessor(joints, 5121, 4, "VEC4");
  attributes["WEIGHTS_0"] = tet.add_accessor(weights, 5126, 4, "VEC4");
  tet.json["skins"] = {
      {{"joints", {1, 2}}, {"inverseBindMatrices", tet.add_accessor(inverse, 5126, 2, "MAT4")}}};
  tet.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}},
                       {{"translation", {500001, 30, 4649776}}, {"children", {2}}},
                       {{"translation", {0, 2 + raised, 0}}}};
  tet.json["scenes"] = {{{"nodes", {0, 1}}}};
  return tet;
}

TEST(GltfOffset, SkinsAreMovedByTheirJoints) {
  const Mesh rest = imported(skinned(0));
  EXPECT_EQ(rest.frame.offset, kFar);
  EXPECT_EQ(rest.positions, kCorners);
  // The boxes of both joints together are 1.5 m tall, so offsets are still multiples of 2 m.
  const Mesh raised = imported(skinned(0.5));
  EXPECT_EQ(raised.frame.offset, kFar);
  EXPECT_EQ(raised.positions[1], (Vec3f{1, 0, 0}));
  EXPECT_EQ(raised.positions[2], (Vec3f{0, 1.5, 0}));
}

}  // namespace
}  // namespace fracture::test
