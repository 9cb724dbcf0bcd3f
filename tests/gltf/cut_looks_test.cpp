// The statements of the file about cut faces: their materials by part, the position of textures on them, and
// their relief.
#include <gtest/gtest.h>

#include <cstring>
#include <utility>

#include "common/gltf/gltf_writer.hpp"
#include "common/solid/cut_materials.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

TEST(CutLooks, CutFacesHaveTheMaterialOfTheirPart) {
  FracturedSolid made = two_halves();
  made.set.fragments[1].source_part = 1;
  GltfOptions options;
  options.interior.materials = {{{"name", "Interior"}}, {{"name", "Interior_2"}}};
  options.interior.of_part = {1, 0};
  const Glb glb(write_glb(made, options));
  ASSERT_EQ(glb.document["materials"].size(), 4u);
  EXPECT_EQ(glb.document["meshes"][0]["primitives"][2]["material"], 3);
  EXPECT_EQ(glb.document["meshes"][1]["primitives"][2]["material"], 2);
  EXPECT_EQ(glb.document["nodes"][0]["extras"]["fracture"]["interior_materials"], json({2, 3}));
}

TEST(CutLooks, JointsHaveTheMaterialOfMortar) {
  FracturedSolid made = two_halves();
  made.set.fragments[0].primitives[2].material = kMortarMaterial;
  GltfOptions options;
  EXPECT_EQ(Glb(write_glb(made, options)).document["meshes"][0]["primitives"][2].count("material"), 0u)
      << "there is none";
  options.interior.materials = {{{"name", "Interior"}}, {{"name", "Interior_Mortar"}}};
  options.interior.mortar = 1;
  const Glb glb(write_glb(made, options));
  EXPECT_EQ(glb.document["meshes"][0]["primitives"][2]["material"], 3);
  EXPECT_EQ(glb.document["meshes"][1]["primitives"][2]["material"], 2);
  EXPECT_EQ(glb.document["nodes"][0]["extras"]["fracture"]["interior_materials"], json({2, 3}));
}

TEST(CutLooks, TexturesAreScaledAndMovedOnCutFacesAlone) {
  const FracturedSolid made = two_halves();
  GltfOptions options;
  options.interior.uvs = {.scale = 4, .u = 0.5, .v = -1};
  const Glb glb(write_glb(made, options));
  const Fragment& f = made.set.fragments[0];
  for (const std::size_t set : {0, 1}) {
    const auto uvs = glb.read<Vec2f>(
        glb.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_" + std::to_string(set)]);
    const std::vector<Vec2f>& before = f.attributes.uvs[set];
    ASSERT_EQ(uvs.size(), before.size());
    for (std::size_t k = 0; k < uvs.size(); ++k) {
      const bool cut = k >= uvs.size() - 4;  // its four corners come last
      EXPECT_EQ(uvs[k], (cut ? Vec2f{4 * before[k].x + 0.5f, 4 * before[k].y - 1} : before[k])) << k;
    }
  }
}

TEST(CutLooks, ReliefStandsBehindTheTexturesOfTheSource) {
  const FracturedSolid made = two_halves();
  GltfOptions options;
  options.interior.detail = CutDetail::kBrick;
  options.interior.materials[0]["normalTexture"] = {{"index", 1}};
  const Glb glb(write_glb(made, options));
  ASSERT_EQ(glb.document["textures"].size(), 3u);
  EXPECT_EQ(glb.document["textures"][1]["source"], 1);
  EXPECT_EQ(glb.document["textures"][2]["source"], 2);
  ASSERT_EQ(glb.document["images"].size(), 3u);
  const json& view = glb.document["bufferViews"][glb.document["images"][1]["bufferView"].get<std::size_t>()];
  const std::vector<std::uint8_t>& normal = detail_maps(CutDetail::kBrick).normal;
  ASSERT_EQ(view["byteLength"], normal.size());
  EXPECT_EQ(std::memcmp(&glb.binary.at(view["byteOffset"].get<std::size_t>()), normal.data(), normal.size()),
            0);
  EXPECT_TRUE(glb.document["meshes"][0]["primitives"][2]["attributes"].contains("TANGENT"));
}

TEST(CutLooks, CutsUnderANormalMapHaveTheFrameThatTheirSourceLacks) {
  const FracturedSolid made = two_halves();  // its sides have the frames that this test needs
  // Products of edges of about 1e-20 m are about 1e-40. Powers of two do not change the directions of edges.
  for (const auto& [normals, scale] :
       {std::pair{false, 1.0f}, std::pair{true, 1.0f}, std::pair{false, 0x1p-66f}}) {
    SCOPED_TRACE(testing::Message() << normals << ", " << scale);
    FracturedSolid bare = made;
    for (Fragment& f : bare.set.fragments) {
      f.attributes.tangents.clear();
      if (!normals) f.attributes.normals.clear();
      for (Vec3f& p : f.positions) p = {scale * p.x, scale * p.y, scale * p.z};
    }
    GltfOptions options;
    options.interior.materials[0]["normalTexture"] = {{"index", 0}};
    const Glb glb(write_glb(bare, options));
    for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
      const Fragment& f = made.set.fragments[k];
      const json& primitives = glb.document["meshes"][k]["primitives"];
      for (const std::size_t outside : {0, 1}) {
        EXPECT_FALSE(primitives[outside]["attributes"].contains("TANGENT"));
        EXPECT_EQ(primitives[outside]["attributes"].contains("NORMAL"), normals);
      }
      const json& attributes = primitives[2]["attributes"];
      const auto normal = glb.read<Vec3f>(attributes.at("NORMAL"));
      const auto tangent = glb.read<Vec4f>(attributes.at("TANGENT"));
      ASSERT_EQ(normal.size(), f.positions.size());
      ASSERT_EQ(tangent.size(), f.positions.size());
      for (std::uint32_t c = 0; c < f.primitives[2].index_count; ++c) {
        const std::uint32_t v = f.indices[f.primitives[2].first_index + c];
        EXPECT_EQ(normal[v], f.attributes.normals[v]);
        EXPECT_EQ(tangent[v], f.attributes.tangents[v]);
      }
      for (const Vec4f& t : tangent) EXPECT_EQ(t.x * t.x + t.y * t.y + t.z * t.z, 1) << "valid everywhere";
    }
  }
}

TEST(CutLooks, CutsHaveTangentsWhoseNormalMapIsInAnEarlierAnswer) {
  GltfOptions options;
  const auto has_tangents = [&] {
    return Glb(write_glb(two_halves(), options))
        .document["meshes"][0]["primitives"][2]["attributes"]
        .contains("TANGENT");
  };
  EXPECT_FALSE(has_tangents());
  options.interior.in_relief = 1;
  EXPECT_TRUE(has_tangents());
}

}  // namespace
}  // namespace fracture::test
