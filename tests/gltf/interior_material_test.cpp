#include "common/gltf/interior_material.hpp"

#include <gtest/gtest.h>

namespace fracture {
namespace {

MaterialLibrary two_materials() {
  MaterialLibrary library;
  library.materials = {
      {{"name", "Rock"},
       {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 3}}}, {"roughnessFactor", 0.4}}},
       {"normalTexture", {{"index", 1}}}},
      {{"name", "1"}, {"doubleSided", true}}};
  return library;
}

TEST(InteriorMaterial, WithoutWishesItIsTheMattGreyCalledInterior) {
  const auto material = interior_material({}, two_materials());
  ASSERT_TRUE(material);
  EXPECT_EQ(*material, plain_interior_material());
  EXPECT_EQ(material->at("name"), "Interior");
}

TEST(InteriorMaterial, AMaterialOfTheSourceIsReusedWithItsTexturesAndStillSaysInterior) {
  const auto material = interior_material({.material = "Rock"}, two_materials());
  ASSERT_TRUE(material);
  EXPECT_EQ(material->at("name"), "Interior_Rock");
  EXPECT_EQ(material->at("pbrMetallicRoughness").at("baseColorTexture").at("index"), 3);
  EXPECT_EQ(material->at("normalTexture").at("index"), 1);
}

TEST(InteriorMaterial, ANameGoesBeforeAnIndex) {
  EXPECT_EQ(interior_material({.material = "1"}, two_materials())->at("doubleSided"), true);
  EXPECT_EQ(interior_material({.material = "0"}, two_materials())->at("name"), "Interior_Rock");
}

TEST(InteriorMaterial, WhatIsAskedForReplacesWhatIsReused) {
  const auto material = interior_material(
      {.material = "Rock", .name = "Inside", .color = Vec3d{1, 0.5, 0}, .metallic = 0.75}, two_materials());
  ASSERT_TRUE(material);
  const auto& pbr = material->at("pbrMetallicRoughness");
  EXPECT_EQ(material->at("name"), "Inside");
  EXPECT_EQ(pbr.at("baseColorFactor"), nlohmann::json({1.0, 0.5, 0.0, 1}));
  EXPECT_FALSE(pbr.contains("baseColorTexture"));
  EXPECT_EQ(pbr.at("roughnessFactor"), 0.4);
  EXPECT_EQ(pbr.at("metallicFactor"), 0.75);
}

TEST(InteriorMaterial, AnUnknownMaterialIsRefusedWithTheNamesThereAre) {
  for (const char* name : {"rock", "2", "-1", "1x"}) {
    const auto material = interior_material({.material = name}, two_materials());
    ASSERT_FALSE(material) << name;
    EXPECT_EQ(material.error().code, ErrorCode::kBadParameter);
    EXPECT_EQ(material.error().pointer, "interior_material");
    EXPECT_EQ(material.error().extra->at("known"), nlohmann::json({"Rock", "1"}));
  }
}

}  // namespace
}  // namespace fracture
