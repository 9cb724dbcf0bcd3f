// Extensions that a glTF file requires are applied, listed in Mesh::dropped, or refused by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/import/losses.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class Required : public ::testing::TestWithParam<const char*> {};

TEST_P(Required, IsReadAndNamedIfItDoesNotTouchTriangles) {
  Tetrahedron tet;
  tet.json["extensionsUsed"] = json::array({GetParam()});
  tet.json["extensionsRequired"] = json::array({GetParam()});
  EXPECT_THAT(dropped_by(tet), ElementsAre(std::string("extension ") + GetParam()));
  EXPECT_DOUBLE_EQ(signed_volume(import_with_losses(tet)), 1.0 / 6);
}

INSTANTIATE_TEST_SUITE_P(Extensions, Required,
                         ::testing::Values("KHR_materials_variants", "KHR_lights_punctual", "KHR_xmp_json_ld",
                                           "KHR_animation_pointer", "EXT_structural_metadata", "VRMC_vrm",
                                           "MSFT_lod", "CESIUM_primitive_outline", "KHR_interactivity",
                                           "AGI_articulations", "EXT_lights_image_based", "EXT_texture_video",
                                           "FB_geometry_metadata", "KHR_node_hoverability",
                                           "KHR_texture_procedurals"));

TEST(GltfRequired, ExtensionsThatAreAppliedAreNotNamed) {
  for (const char* name : {"KHR_node_visibility", "KHR_meshopt_compression", "KHR_mesh_quantization"}) {
    Tetrahedron tet;
    tet.json["extensionsUsed"] = json::array({name});
    tet.json["extensionsRequired"] = json::array({name});
    EXPECT_THAT(dropped_by(tet), IsEmpty()) << name;
  }
}

TEST(GltfRequired, ExtensionsThatChangeGeometryAreRefusedByName) {
  for (const char* name :
       {"KHR_accessor_float64", "KHR_gaussian_splatting", "KHR_mesh_primitive_restart", "ACME_holograms"}) {
    Tetrahedron tet;
    tet.json["extensionsRequired"] = json::array({name});
    const Expected<Mesh> mesh = import_text(tet.glb(), MeshFormat::kGlb);
    ASSERT_FALSE(mesh) << name;
    EXPECT_EQ(mesh.error().code, ErrorCode::kUnsupportedFeature);
    EXPECT_NE(mesh.error().detail.find(name), std::string::npos) << mesh.error().detail;
  }
}

TEST(GltfRequired, HiddenNodesAndThoseBelowThemAreLeftOutAndNamed) {
  Tetrahedron tet;
  const json hidden = {{"KHR_node_visibility", {{"visible", false}}}},
             seen = {{"KHR_node_visibility", {{"visible", true}}}};
  tet.json["nodes"] = {{{"mesh", 0}, {"name", "Seen"}, {"extensions", seen}},
                       {{"name", "Hidden"}, {"extensions", hidden}, {"children", {2}}},
                       {{"mesh", 0}, {"name", "Below"}, {"extensions", seen}}};
  tet.json["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(import_with_losses(tet).node_names, std::vector<std::string>{"Seen"});
  EXPECT_THAT(dropped_by(tet), UnorderedElementsAre("node Hidden", "node Below"));
  // A hidden joint still poses the mesh.
  std::string joints, weights;
  put<std::uint8_t>(joints, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  put<float>(weights, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  tet.primitive()["attributes"]["JOINTS_0"] = tet.add_accessor(joints, 5121, 4, "VEC4");
  tet.primitive()["attributes"]["WEIGHTS_0"] = tet.add_accessor(weights, 5126, 4, "VEC4");
  tet.json["skins"] = {{{"joints", {1}}}};
  tet.node()["skin"] = 0;
  tet.json["nodes"][1]["translation"] = {0, 0, 7};
  EXPECT_EQ(import_with_losses(tet).positions[0], (Vec3f{0, 0, 7}));
}

TEST(GltfRequired, TheCenterOfCesiumRtcIsAddedToTranslations) {
  Tetrahedron tet;
  tet.json["extensionsRequired"] = json::array({"CESIUM_RTC"});
  tet.json["extensions"]["CESIUM_RTC"]["center"] = {10, 20, 30};
  tet.node()["scale"] = {2, 2, 2};
  tet.node()["translation"] = {1, 0, 0};
  EXPECT_EQ(import_with_losses(tet).positions[1], (Vec3f{13, 20, 30})) << "the centre is not scaled";
  EXPECT_THAT(dropped_by(tet), IsEmpty());
  for (const json& wrong : {json(5), json::array({1, 2}), json::array({1, 2, "3"})}) {
    tet.json["extensions"]["CESIUM_RTC"]["center"] = wrong;
    const Expected<Mesh> mesh = import_text(tet.glb(), MeshFormat::kGlb);
    ASSERT_FALSE(mesh) << wrong;
    EXPECT_EQ(mesh.error().pointer, "/extensions/CESIUM_RTC/center");
  }
}

}  // namespace
}  // namespace fracture::test
