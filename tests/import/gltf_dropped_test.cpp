// Everything in a glTF file is in the mesh, is applied to it, or is listed in Mesh::dropped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/mesh/material_library.hpp"
#include "common/mesh/source_tree.hpp"
#include "tests/import/losses.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST(GltfDropped, AFileOfTrianglesAloneLosesNothing) {
  Tetrahedron tet;
  std::string uvs;
  put<float>(uvs, {0, 0, 1, 0, 0, 1, 1, 1});
  tet.primitive()["attributes"]["TEXCOORD_0"] = tet.add_accessor(uvs, 5126, 4, "VEC2");
  tet.json["asset"]["generator"] = "by hand";
  tet.json["scenes"][0]["name"] = "Scene";
  tet.json["materials"] = {{{"name", "Paint"}, {"extras", {{"shader", "foo"}}}}};
  tet.primitive()["material"] = 0;
  EXPECT_THAT(dropped_by(tet), IsEmpty());
  EXPECT_THAT(import_with_losses(tet).node_extras, IsEmpty());
}

TEST(GltfDropped, LightsCamerasAndAnimationsAreNamedByThemselvesOrByTheirNodes) {
  Tetrahedron tet;
  tet.json["extensionsUsed"] = json::array({"KHR_lights_punctual"});
  tet.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"name", "Lamp"}}, {{"type", "spot"}}, {{"type", "spot"}}};
  tet.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}};
  tet.json["nodes"].push_back({{"name", "Eye"}, {"camera", 0}});
  tet.json["nodes"].push_back({{"name", "Torch"}, {"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}});
  tet.json["scenes"][0]["nodes"] = {0, 1, 2};
  tet.json["animations"] = {{{"name", "Spin"}, {"channels", json::array()}, {"samplers", json::array()}},
                            {{"channels", json::array()}, {"samplers", json::array()}}};
  EXPECT_THAT(dropped_by(tet),
              UnorderedElementsAre("extension KHR_lights_punctual", "light Lamp", "light Torch",
                                   "light /extensions/KHR_lights_punctual/lights/2", "camera Eye",
                                   "animation Spin", "animation /animations/1"));
  const Mesh mesh = import_with_losses(tet);
  EXPECT_TRUE(mesh.remarks.empty()) << "the list says it";
  ASSERT_EQ(mesh.empty_nodes.size(), 2u) << "the places of the camera and the light";
  EXPECT_EQ(mesh.empty_nodes[0].name, "Eye");
}

TEST(GltfDropped, NodesWithoutAMeshKeepTheirPlaceInTheSceneAndTheirExtras) {
  Tetrahedron tet;
  tet.json["nodes"] = {
      {{"name", "House"}, {"translation", {0, 1, 0}}, {"scale", {2, 2, 2}}, {"children", {1, 2}}},
      {{"mesh", 0}, {"name", "Wall"}},
      {{"name", "socket"}, {"translation", {1, 0, 0}}, {"children", {3}}},
      {{"name", "tip"}, {"translation", {0, 0, 3}}}};
  tet.json["nodes"][2]["extras"] = {{"socket", true}, {"fracture", 1}};
  const Mesh mesh = import_with_losses(tet);
  const EmptyNode socket{"socket", {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {2, 1, 0}, "\"socket\":true"},
      tip{"tip", {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {2, 1, 6}, ""};
  EXPECT_THAT(mesh.empty_nodes, ElementsAre(socket, tip));
  EXPECT_THAT(dropped_by(tet), IsEmpty()) << "the house is a group";
}

TEST(GltfDropped, NodesWhoseTransformANodeCannotHaveAndThoseBeyondTheLimitAreNamed) {
  Tetrahedron tet;
  const double h = 0.70710678118654752440;  // a turn by an eighth below an uneven scale is a shear
  tet.json["nodes"] = {
      {{"mesh", 0}, {"name", "tet"}},
      {{"name", "uneven"}, {"scale", {1, 3, 1}}, {"children", {2}}},
      {{"name", "sheared"}, {"rotation", {0, 0, std::sqrt((1 - h) / 2), std::sqrt((1 + h) / 2)}}},
      {{"name", "flat"}, {"scale", {1, 0, 1}}}};
  tet.json["scenes"][0]["nodes"] = {0, 1, 3};
  EXPECT_THAT(dropped_by(tet), UnorderedElementsAre("node sheared", "node flat"));
  EXPECT_EQ(import_with_losses(tet).empty_nodes.size(), 1u);
  for (int k = 0; k < 1'010; ++k) {
    tet.json["scenes"][0]["nodes"].push_back(tet.json["nodes"].size());
    tet.json["nodes"].push_back({{"name", "socket"}, {"translation", {0, 0, k}}});
  }
  EXPECT_EQ(import_with_losses(tet).empty_nodes.size(), 1'000u);
  EXPECT_THAT(dropped_by(tet), UnorderedElementsAre("node sheared", "node flat", "node socket"));
}

TEST(GltfDropped, CollidersOfTheSourceAreNoEmptyNodes) {
  Tetrahedron tet;
  tet.json["nodes"].push_back({{"name", "tet_00_collider"}});
  tet.json["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["collider"] = json::object();
  tet.node()["children"] = json::array({1});
  EXPECT_THAT(dropped_by(tet),
              UnorderedElementsAre("extension KHR_physics_rigid_bodies", "node tet_00_collider"));
  EXPECT_THAT(import_with_losses(tet).empty_nodes, IsEmpty());
}

TEST(GltfDropped, NodesThatTheAnswerLacksAreNamed) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"name", "House"}, {"children", {1, 2}}},
                       {{"name", "Wall"}, {"mesh", 0}},
                       {{"name", "socket_fx"}},
                       {{"name", "Elsewhere"}, {"mesh", 0}},
                       {{"name", "Alone"}},
                       json::object()};
  tet.json["scenes"] = {{{"nodes", {0, 5}}}, {{"nodes", {3}}, {"name", "Other"}}};
  EXPECT_THAT(dropped_by(tet), UnorderedElementsAre("node Elsewhere", "node Alone", "scene Other"));
  const Mesh mesh = import_with_losses(tet);
  EXPECT_EQ(mesh.node_names, std::vector<std::string>{"Wall"});
  EXPECT_THAT(mesh.empty_nodes, ElementsAre(EmptyNode{.name = "socket_fx"}, EmptyNode{.name = "empty"}));
}

TEST(GltfDropped, NodesAboveMeshesAreGroupsWithTheirExtrasUpToALimit) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"name", "House"}, {"children", {1}}, {"extras", {{"floors", 2}}}},
                       {{"children", {2}}, {"extras", {{"lost", true}}}},
                       {{"name", "Wall"}, {"mesh", 0}, {"extras", {{"hp", 7}}}}};
  tet.json["scenes"][0]["nodes"] = {0};
  EXPECT_THAT(dropped_by(tet), UnorderedElementsAre("node /nodes/1", "extras /nodes/1"));
  Mesh mesh = import_with_losses(tet);
  ASSERT_TRUE(mesh.source_tree);
  EXPECT_EQ(*mesh.source_tree, (SourceTree{{{"House", kNoIndex, "\"floors\":2"}, {"Wall", 0}}, {1}}));
  EXPECT_EQ(mesh.node_extras, std::vector<std::string>{"\"hp\":7"}) << "fragments have them";

  tet.json["nodes"] = json::array();
  for (int k = 0; k < 70; ++k)
    tet.json["nodes"].push_back({{"name", std::to_string(k)}, {"children", {k + 1}}});
  tet.json["nodes"].push_back({{"name", "Wall"}, {"mesh", 0}});
  mesh = import_with_losses(tet);
  ASSERT_TRUE(mesh.source_tree);
  EXPECT_EQ(mesh.source_tree->nodes.size(), 64u);
  EXPECT_EQ(mesh.source_tree->nodes.back(), (SourceNode{"63", 62}));
  EXPECT_EQ(mesh.source_tree->of_instance, std::vector<std::uint32_t>{63});
  EXPECT_THAT(dropped_by(tet),
              UnorderedElementsAre("node 64", "node 65", "node 66", "node 67", "node 68", "node 69"));
}

// Each fragment may have the name of its node. é has two bytes, of which the second one would be the 257th.
TEST(GltfDropped, LongNamesOfNodesAreCutAtACharacter) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"name", std::string(255, 'a') + "\xc3\xa9"}, {"children", {1}}},
                       {{"name", "Wall"}, {"mesh", 0}}};
  tet.json["scenes"][0]["nodes"] = {0};
  const Mesh mesh = import_with_losses(tet);
  ASSERT_TRUE(mesh.source_tree);
  EXPECT_EQ(mesh.source_tree->nodes[0].name, std::string(255, 'a'));
}

TEST(GltfDropped, AMeshThatNoNodeShowsIsNamed) {
  Tetrahedron tet;
  tet.json["meshes"].push_back(tet.json["meshes"][0]);
  tet.json["meshes"][1]["name"] = "Spare";
  EXPECT_THAT(dropped_by(tet), ElementsAre("mesh Spare"));
}

TEST(GltfDropped, AttributesAndPrimitivesThatFragmentsCannotHaveAreNamed) {
  Tetrahedron tet;
  std::string numbers, uvs;
  put<float>(numbers, {1, 2, 3, 4});
  put<float>(uvs, {0, 0, 1, 0, 0, 1, 1, 1});
  json& mesh = tet.json["meshes"][0];
  mesh["name"] = "Box";
  json& attributes = tet.primitive()["attributes"];
  attributes["_FEATURE_ID_0"] = tet.add_accessor(numbers, 5126, 4, "SCALAR");
  attributes["TEXCOORD_0"] = tet.add_accessor(uvs, 5126, 4, "VEC2");
  attributes["TEXCOORD_2"] = attributes["TEXCOORD_0"];  // TEXCOORD_1 is missing, so this one is not read
  mesh["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 0}});
  mesh["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 3}});
  EXPECT_THAT(dropped_by(tet),
              UnorderedElementsAre("attribute _FEATURE_ID_0 of Box", "attribute TEXCOORD_2 of Box",
                                   "points Box", "lines Box"));
  const Mesh read = import_with_losses(tet);
  EXPECT_EQ(read.attributes.uvs.size(), 1u);
  EXPECT_EQ(read.triangles.size(), 4u);
}

TEST(GltfDropped, TangentsThatNoNormalMapUsesAreNamed) {
  Tetrahedron tet;
  std::string tangents, uvs;
  put<float>(tangents, {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1});
  put<float>(uvs, {0, 0, 1, 0, 0, 1, 1, 1});
  tet.json["meshes"][0]["name"] = "Box";
  json& attributes = tet.primitive()["attributes"];
  attributes["TANGENT"] = tet.add_accessor(tangents, 5126, 4, "VEC4");
  attributes["TEXCOORD_0"] = tet.add_accessor(uvs, 5126, 4, "VEC2");
  EXPECT_THAT(dropped_by(tet), ElementsAre("attribute TANGENT of Box"));
  tet.json["images"] = {{{"uri", "data:image/png;base64,iVBORw0KGgo="}}};  // the signature of a PNG
  tet.json["textures"] = {{{"source", 0}}};
  tet.json["materials"] = {json::object(), {{"normalTexture", {{"index", 0}}}}};
  tet.primitive()["material"] = 0;
  EXPECT_THAT(dropped_by(tet), ElementsAre("attribute TANGENT of Box"));
  tet.primitive()["material"] = 1;
  EXPECT_THAT(dropped_by(tet), IsEmpty());
  tet.primitive()["material"] = 0;
  tet.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "bumpy"}}};
  tet.primitive()["extensions"]["KHR_materials_variants"]["mappings"] =
      json::array({{{"material", 1}, {"variants", json::array({0})}}});
  EXPECT_THAT(dropped_by(tet), IsEmpty()) << "a variant uses them";
}

TEST(GltfDropped, ImagesThatCannotBeReadAreNamed) {
  Tetrahedron tet;
  tet.json["images"] = {{{"uri", "bricks.png"}},
                        {{"bufferView", 0}, {"name", "odd"}},
                        json::object(),
                        {{"uri", "data:image/png;base64,iVBORw0KGgo="}, {"name", "good"}}};
  EXPECT_THAT(dropped_by(tet), ElementsAre("image bricks.png", "image odd", "image /images/2"));
  EXPECT_EQ(import_with_losses(tet).library->images.size(), 1u);
}

TEST(GltfDropped, PrimitivesWithoutPositionsAreNamed) {
  Tetrahedron tet;
  tet.json["meshes"][0]["name"] = "Box";
  tet.json["meshes"][0]["primitives"].push_back({{"attributes", json::object()}, {"mode", 4}});
  EXPECT_THAT(dropped_by(tet), ElementsAre("primitive Box"));
}

TEST(GltfDropped, BonesAndMorphTargetsAreNamed) {
  Tetrahedron tet;
  std::string moves;
  put<float>(moves, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  tet.json["meshes"][0]["name"] = "Box";
  tet.primitive()["targets"] = {{{"POSITION", tet.add_accessor(moves, 5126, 4, "VEC3")}}};
  tet.json["skins"] = {{{"name", "Rig"}, {"joints", {1}}}};
  tet.json["nodes"].push_back({{"name", "Bone"}});
  tet.json["scenes"][0]["nodes"] = {0, 1};
  EXPECT_THAT(dropped_by(tet), UnorderedElementsAre("skin Rig", "bone Bone", "morph targets Box"));
}

TEST(GltfDropped, ExtrasOfNodesAreKeptAndOthersAreNamed) {
  Tetrahedron tet;
  tet.node()["extras"] = {
      {"hp", 120}, {"loot", "gem \"x\""}, {"fracture", {{"id", 7}}}, {"intact", true}, {"whole", 1}};
  tet.json["scenes"][0]["extras"] = {{"scene", "?"}};
  tet.json["scenes"][0]["name"] = "Stage";
  tet.json["meshes"][0]["extras"] = {{"mesh", "?"}};
  tet.json["meshes"][0]["name"] = "Box";
  tet.primitive()["extras"] = 5;
  tet.json["asset"]["extras"] = {{"asset", "?"}};
  EXPECT_THAT(dropped_by(tet), UnorderedElementsAre("extras Stage", "extras Box", "extras a primitive of Box",
                                                    "extras /asset/extras"));
  const Mesh mesh = import_with_losses(tet);
  ASSERT_EQ(mesh.node_extras.size(), 1u);
  EXPECT_EQ(json::parse("{" + mesh.node_extras[0] + "}"), json({{"hp", 120}, {"loot", "gem \"x\""}}))
      << "without the results of an earlier fracture";
}

TEST(GltfDropped, ExtrasThatFragmentsCannotCarryAreNamed) {
  Tetrahedron tet;
  tet.node()["extras"] = json::array({1, 2});
  EXPECT_THAT(dropped_by(tet), ElementsAre("extras tet"));
  tet.node()["extras"] = {{"long", std::string(5'000, 'x')}};
  EXPECT_THAT(dropped_by(tet), ElementsAre("extras tet"));
  EXPECT_THAT(import_with_losses(tet).node_extras, IsEmpty());
  tet.node()["extras"] = {{"fracture", {{"id", 7}}}};
  EXPECT_THAT(dropped_by(tet), IsEmpty()) << "the answer writes its own";
}

TEST(GltfDropped, EachInstanceCarriesTheExtrasOfItsNodeAndOtherNodesNone) {
  Tetrahedron tet;
  std::string moves;
  put<float>(moves, {0, 0, 0, 5, 0, 0});
  tet.json["nodes"] = {{{"mesh", 0}, {"name", "plain"}}, {{"mesh", 0}, {"name", "pair"}}};
  tet.json["nodes"][1]["extras"] = {{"hp", 1}};
  tet.json["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", tet.add_accessor(moves, 5126, 2, "VEC3")}, {"_ID", 0}};
  tet.json["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(import_with_losses(tet).node_extras, (std::vector<std::string>{"", "\"hp\":1", "\"hp\":1"}));
  EXPECT_THAT(dropped_by(tet), ElementsAre("attribute _ID of pair"));
}

TEST(GltfDropped, UnknownExtensionsAreNamedAndThoseInExtrasAreNone) {
  Tetrahedron tet;
  tet.node()["extensions"]["ACME_holograms"] = json::object();
  tet.node()["extras"]["extensions"]["ACME_text"] = json::object();
  tet.json["extensionsUsed"] = {"ACME_holograms", "KHR_materials_unlit", "KHR_mesh_quantization"};
  EXPECT_THAT(dropped_by(tet), ElementsAre("extension ACME_holograms"));
}

/// Collects the value of each member `name`, except those of scenes.
void collect_names(const json& value, std::vector<std::string>& names) {
  for (const auto& [key, child] : value.items()) {
    if (key == "name" && child.is_string()) names.push_back(child.get<std::string>());
    if (key != "scenes" && child.is_structured()) collect_names(child, names);
  }
}

TEST(GltfDropped, EveryNameInTheFileIsInTheMeshOrListed) {
  Tetrahedron tet;
  std::string numbers;
  put<float>(numbers, {1, 2, 3, 4});
  tet.primitive()["attributes"]["_HEAT"] = tet.add_accessor(numbers, 5126, 4, "SCALAR");
  tet.primitive()["material"] = 0;
  tet.json["materials"] = {{{"name", "Paint"}}, {{"name", "Unused"}}};
  tet.json["meshes"][0]["name"] = "Box";
  tet.json["meshes"].push_back({{"name", "Spare"}, {"primitives", tet.json["meshes"][0]["primitives"]}});
  tet.json["extensions"] = {
      {"KHR_lights_punctual", {{"lights", json::array({{{"type", "point"}, {"name", "lamp"}}})}}},
      {"KHR_materials_variants", {{"variants", json::array({{{"name", "snow"}}})}}}};
  tet.json["cameras"] = json::array({{{"type", "orthographic"}, {"name", "lens"}}});
  tet.json["skins"] = json::array({{{"name", "rig"}, {"joints", {6}}}});
  tet.json["animations"] =
      json::array({{{"name", "spin"}, {"channels", json::array()}, {"samplers", json::array()}}});
  tet.json["nodes"] = {
      {{"name", "\u684c\u5b50"}, {"mesh", 0}},
      {{"name", "group"}, {"children", {2}}},
      {{"name", "in group"}, {"mesh", 0}},
      {{"name", "cam"}, {"camera", 0}},
      {{"name", "lamp holder"}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
      {{"name", "socket_fx"}},
      {{"name", "bone"}},
      {{"name", "outside"}, {"mesh", 0}},
      {{"name", "hidden"}, {"mesh", 0}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}}};
  tet.json["scenes"][0]["nodes"] = {0, 1, 3, 4, 5, 6, 8};
  const Mesh mesh = import_with_losses(tet);
  std::string found = mesh.library->materials.dump() + mesh.library->variants.dump();
  for (const std::string& name : mesh.node_names) found += "|" + name + "|";
  ASSERT_TRUE(mesh.source_tree);
  for (const SourceNode& node : mesh.source_tree->nodes) found += "|" + node.name + "|";
  for (const NodeGroup& group : mesh.groups) found += "|" + group.name + "|";
  for (const EmptyNode& node : mesh.empty_nodes) found += "|" + node.name + "|";
  for (const Dropped& entry : mesh.dropped) found += "|" + entry.name + "|";
  std::vector<std::string> names;
  collect_names(tet.json, names);
  EXPECT_EQ(names.size(), 18u);
  for (const std::string& name : names) EXPECT_NE(found.find(name), std::string::npos) << name;
  EXPECT_NE(found.find("_HEAT"), std::string::npos);
}

// -- values of wrong types

TEST(GltfDropped, ListsOfWrongTypesDoNoHarm) {
  for (const json& odd : {json(5), json("x"), json::array({7, "y", nullptr}), json::object()}) {
    Tetrahedron tet;
    tet.json["cameras"] = odd;
    tet.json["extensions"] = {{"KHR_lights_punctual", {{"lights", odd}}}, {"KHR_materials_variants", odd}};
    tet.json["extensionsUsed"] = odd;
    tet.node()["extensions"] = {{"KHR_lights_punctual", odd},
                                {"EXT_mesh_gpu_instancing", {{"attributes", 5}}}};
    tet.node()["extras"] = odd;
    EXPECT_EQ(import_with_losses(tet).triangles.size(), 4u) << odd;
    EXPECT_THAT(dropped_by(tet), Contains("extension KHR_lights_punctual"));
  }
}

}  // namespace
}  // namespace fracture::test
