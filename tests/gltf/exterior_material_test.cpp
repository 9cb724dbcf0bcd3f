// The materials of the outside: those of the asset, or those of a preset.
#include "common/gltf/exterior_material.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "common/gltf/gltf_writer.hpp"
#include "common/mesh/material_library.hpp"
#include "common/solid/solid.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// Three triangles: one with a textured material that is transparent by an extension, one without a material,
/// and one with a plain material.
Mesh three_kinds() {
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"name", "Painted"},
                         {"pbrMetallicRoughness",
                          {{"baseColorTexture", {{"index", 0}}},
                           {"baseColorFactor", {0.5, 1, 1, 1}},
                           {"metallicRoughnessTexture", {{"index", 0}}}}},
                         {"normalTexture", {{"index", 0}}},
                         {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.9}}}}}},
                        {{"name", "Unused"}},
                        {{"name", "Plain"}, {"doubleSided", true}}};
  library->textures = {{{"source", 0}}};
  library->images.resize(1);
  Mesh mesh;
  mesh.library = std::move(library);
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 1}, {1, 2, 0}};
  mesh.material = {0, kNoIndex, 2};
  return mesh;
}

ExteriorLook ice(ExteriorChoice choice) {
  return {.choice = choice, .color = Vec3d{0.25, 0.5, 1}, .roughness = 0.15, .metallic = 0, .opacity = 0.75};
}

TEST(ExteriorMaterial, WithoutAPresetOrAsTheAssetHasItNothingIsMade) {
  for (const ExteriorLook& look :
       {ExteriorLook{}, ExteriorLook{.choice = ExteriorChoice::kMaterial}, ice(ExteriorChoice::kAsset)}) {
    const ExteriorMaterials made = exterior_materials(look, three_kinds());
    EXPECT_TRUE(made.materials.empty());
    for (const std::uint32_t source : {0u, 2u, kNoIndex}) EXPECT_EQ(made.of(source), kNoIndex);
  }
}

TEST(ExteriorMaterial, WhatHasNoMaterialIsMadeOfThePreset) {
  const ExteriorMaterials made = exterior_materials(ice(ExteriorChoice::kAuto), three_kinds());
  EXPECT_EQ(made.of(0), kNoIndex);
  EXPECT_EQ(made.of(2), kNoIndex);
  ASSERT_EQ(made.of(kNoIndex), 0u);
  ASSERT_EQ(made.materials.size(), 1u);
  const json expected = {
      {"name", "Exterior"},
      {"alphaMode", "BLEND"},
      {"pbrMetallicRoughness",
       {{"baseColorFactor", {0.25, 0.5, 1.0, 0.75}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.15}}}};
  EXPECT_EQ(made.materials[0], expected);
}

TEST(ExteriorMaterial, NothingIsMadeWhereEverythingHasAMaterial) {
  Mesh mesh = three_kinds();
  mesh.material[1] = 2;
  EXPECT_TRUE(exterior_materials(ice(ExteriorChoice::kAuto), mesh).materials.empty());
}

// Inner sides of walls are made of the cuts' materials.
TEST(ExteriorMaterial, NothingIsMadeForCavities) {
  Mesh mesh = three_kinds();
  mesh.material[1] = kCavityMaterial;
  EXPECT_TRUE(exterior_materials(ice(ExteriorChoice::kAuto), mesh).materials.empty());
}

TEST(ExteriorMaterial, NoTwoMaterialsAreCalledExterior) {
  Mesh mesh = three_kinds();
  auto library = std::make_shared<MaterialLibrary>(*mesh.library);
  library->materials[0]["name"] = "Exterior";
  library->materials[1] = json::object();  // without a name
  library->materials[2]["name"] = "Exterior_2";
  mesh.library = std::move(library);
  const ExteriorMaterials made = exterior_materials(ice(ExteriorChoice::kAuto), mesh);
  ASSERT_EQ(made.materials.size(), 1u);
  EXPECT_EQ(made.materials[0].at("name"), "Exterior_3");
}

TEST(ExteriorMaterial, ColorsOfVerticesAreNotMultipliedByThePresets) {
  Mesh mesh = three_kinds();
  mesh.attributes.colors = {{{1, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, 1}}};
  const ExteriorMaterials made = exterior_materials(ice(ExteriorChoice::kAuto), mesh);
  EXPECT_EQ(made.materials.at(0).at("pbrMetallicRoughness").at("baseColorFactor"),
            json({1.0, 1.0, 1.0, 0.75}));
}

TEST(ExteriorMaterial, EverythingOfThePresetKeepsItsColorsAndRelief) {
  const ExteriorMaterials made = exterior_materials(ice(ExteriorChoice::kMaterial), three_kinds());
  ASSERT_EQ(made.materials.size(), 3u) << "two that are used, and that of what has none";
  const json& painted = made.materials.at(made.of(0));
  EXPECT_EQ(painted.at("name"), "Painted");
  EXPECT_EQ(painted.at("normalTexture").at("index"), 0);
  EXPECT_EQ(painted.at("alphaMode"), "BLEND");
  EXPECT_FALSE(painted.contains("extensions")) << "the preset says how light goes through";
  const json& pbr = painted.at("pbrMetallicRoughness");
  EXPECT_EQ(pbr.at("baseColorTexture").at("index"), 0);
  EXPECT_EQ(pbr.at("baseColorFactor"), json({0.5, 1.0, 1.0, 0.75}));
  EXPECT_EQ(pbr.at("roughnessFactor"), 0.15);
  EXPECT_FALSE(pbr.contains("metallicRoughnessTexture")) << "it would be a factor of the preset's";
  EXPECT_EQ(made.materials.at(made.of(2)).at("doubleSided"), true);
  EXPECT_EQ(made.materials.at(made.of(kNoIndex)).at("name"), "Exterior");
}

/// The two halves next to a part that stays whole. One triangle of that part has no material.
FracturedSolid halves_beside_a_whole() {
  FracturedSolid made = two_halves();
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  auto rest = std::make_shared<Mesh>();
  rest->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  rest->triangles = {{0, 1, 2}, {0, 2, 1}};
  rest->material = {0, kNoIndex};
  rest->node = {0, 0};
  rest->node_names = {"lamp"};
  rest->library = mesh->library;
  mesh->material = {0, 1};  // the materials that the halves have
  mesh->passed_through = rest;
  made.set.source = mesh;
  return made;
}

TEST(ExteriorMaterial, FragmentsHaveItAndWhatStaysWholeHasNot) {
  const FracturedSolid made = halves_beside_a_whole();
  GltfOptions options;
  options.exterior = exterior_materials(ice(ExteriorChoice::kMaterial), *made.set.source);
  const Glb glb(write_glb(made, options));
  const json& document = glb.document;
  // Two materials of the source, one of the cuts, and as many as the fragments have.
  ASSERT_EQ(document["materials"].size(), 3 + options.exterior.materials.size());
  const json& half = document["meshes"][0]["primitives"];
  ASSERT_EQ(half.size(), 3u);
  EXPECT_EQ(half[0]["material"], 3u + options.exterior.of(0));
  EXPECT_EQ(half[1]["material"], 3u + options.exterior.of(1));
  EXPECT_EQ(half[2]["material"], 2u);
  EXPECT_TRUE(half[0]["attributes"].contains("TANGENT")) << "its relief is that of the source";
  const json& whole = document["meshes"].back()["primitives"];
  ASSERT_EQ(whole.size(), 2u);
  EXPECT_EQ(whole[0]["material"], 0u);
  EXPECT_FALSE(whole[1].contains("material"));
  EXPECT_EQ(document["nodes"][0]["extras"]["fracture"]["interior_materials"], json({2}));
}

}  // namespace
}  // namespace fracture::test
