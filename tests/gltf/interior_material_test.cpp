#include "common/gltf/interior_material.hpp"
#include "common/mesh/material_library.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace fracture {
namespace {

using nlohmann::json;

/// A mesh of two triangles, one of each material, with UVs in [0, `reach`]².
Mesh two_materials(float reach = 1) {
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {
      {{"name", "Rock"},
       {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 3}}}, {"roughnessFactor", 0.4}}},
       {"normalTexture", {{"index", 1}}}},
      {{"name", "1"}, {"doubleSided", true}}};
  library->textures = {{{"source", 0}}, {{"source", 0}}, {{"source", 0}}, {{"source", 0}}};
  library->images.resize(1);
  Mesh mesh;
  mesh.library = std::move(library);
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.attributes.uvs = {{{0, 0}, {reach, 0}, {0, reach}}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
  mesh.material = {0, 1};
  mesh.triangle_color = {{{32768, 16384, 0}, 1}, {{65535, 65535, 65535}, 1}};
  return mesh;
}

Solid solid_of(Mesh mesh, const std::vector<std::optional<LinearColor>>& part_colors = {std::nullopt}) {
  Solid solid;
  solid.source = std::make_shared<const Mesh>(std::move(mesh));
  for (const auto& color : part_colors) {
    Part& part = solid.parts.emplace_back();
    part.volume = 1;
    part.color = color;
  }
  return solid;
}

/// The single interior material of a solid without colours.
json material_of(const InteriorLook& look, Mesh mesh = two_materials(4)) {
  const auto made = interior_materials(look, solid_of(std::move(mesh)));
  EXPECT_EQ(made.value().materials.size(), 1u);
  EXPECT_TRUE(made->of_part.empty());
  return made->materials.at(0);
}

TEST(InteriorMaterial, WithoutWishesAndColorsItIsTheMattGreyCalledInterior) {
  EXPECT_EQ(material_of({}), plain_interior_material());
  EXPECT_EQ(material_of({}).at("name"), "Interior");
}

TEST(InteriorMaterial, AMaterialOfTheSourceIsReusedWithItsTexturesAndStillSaysInterior) {
  const json material = material_of({.material = "Rock"});
  EXPECT_EQ(material.at("name"), "Interior_Rock");
  EXPECT_EQ(material.at("pbrMetallicRoughness").at("baseColorTexture").at("index"), 3);
  EXPECT_EQ(material.at("normalTexture").at("index"), 1);
}

// A file of fragments that breaks again already has an "Interior", and after the next time an "Interior_2".
TEST(InteriorMaterial, NewCutsGetANameThatTheSourceDoesNotHave) {
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"name", "Interior"}}, {{"name", "Interior_2"}}, json::object()};
  Mesh mesh;
  mesh.library = std::move(library);
  EXPECT_EQ(material_of({}, mesh).at("name"), "Interior_3");
  EXPECT_EQ(material_of({.name = "Interior"}, mesh).at("name"), "Interior");
}

TEST(InteriorMaterial, MortarAndCrumbsGetNamesThatTheSourceDoesNotHave) {
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {
      {{"name", "Interior_Crushed"}}, {{"name", "Interior_Mortar"}}, {{"name", "Interior_Mortar_2"}}};
  Mesh mesh;
  mesh.library = std::move(library);
  const InteriorLook look{.crushed = 0.5, .mortar = Vec3d{0.5, 0.45, 0.4}};
  const auto made = interior_materials(look, solid_of(std::move(mesh))).value();
  ASSERT_EQ(made.materials.size(), 3u);
  EXPECT_EQ(made.materials[0].at("name"), "Interior");
  EXPECT_EQ(made.materials[1].at("name"), "Interior_Mortar_3");
  EXPECT_EQ(made.materials[2].at("name"), "Interior_Crushed_2");
}

TEST(InteriorMaterial, AnAtlasIsNotStretchedOverCuts) {
  const json material = material_of({.material = "Rock"}, two_materials(1));
  EXPECT_EQ(material.at("name"), "Interior_Rock");
  EXPECT_FALSE(material.contains("normalTexture"));
  const json& pbr = material.at("pbrMetallicRoughness");
  EXPECT_FALSE(pbr.contains("baseColorTexture"));
  EXPECT_EQ(pbr.at("baseColorFactor"), json({0.5, 0.25, 0.0, 1.0}));
  EXPECT_EQ(pbr.at("roughnessFactor"), 0.4);
  EXPECT_TRUE(material_of({.material = "Rock", .choice = InteriorChoice::kTexture}, two_materials(1))
                  .contains("normalTexture"));
}

TEST(InteriorMaterial, CrumbsOfWhatIsCrushedAreWhite) {
  Solid solid = solid_of(two_materials(), {LinearColor{65535, 0, 0}, LinearColor{0, 0, 65535}});
  solid.parts[1].volume = 3;
  const InteriorLook look{.opacity = 0.7, .crushed = 0.5};
  // Ten fragments of 4 m3 together: half of the mean is 0.2 m3.
  const auto made = interior_materials(look, solid, kUninterrupted, 10).value();
  EXPECT_NEAR(made.crushed_below, 0.2, 1e-12);
  ASSERT_EQ(made.materials.size(), 3u);
  EXPECT_EQ(made.of(0, 0.21), made.of(0));
  EXPECT_EQ(made.of(1, 0.21), made.of(1));
  EXPECT_EQ(made.of(0) + made.of(1), 1u) << "the first two";
  EXPECT_EQ(made.of(0, 0.19), 2u);
  EXPECT_EQ(made.of(1, 0.19), 2u);
  const json& white = made.materials[2];
  EXPECT_EQ(white.at("name"), "Interior_Crushed");
  EXPECT_FALSE(white.contains("alphaMode")) << "opaque";
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_GT(white.at("pbrMetallicRoughness").at("baseColorFactor").at(k).get<double>(), 0.8);
  EXPECT_EQ(interior_materials({}, solid, kUninterrupted, 10)->materials.size(), 2u)
      << "nothing else is crushed";
}

TEST(InteriorMaterial, CavitiesStandBehindWhatIsCrushed) {
  Solid solid = solid_of(two_materials(), {LinearColor{65535, 0, 0}, LinearColor{0, 0, 65535}});
  solid.report.parts_hollowed = 2;
  const auto made = interior_materials({.crushed = 0.5}, solid).value();
  EXPECT_EQ(made.materials.size(), 3u);
  EXPECT_EQ(made.cavities.size(), 2u) << "the inner sides of walls are not crushed";
  EXPECT_EQ(made.of(0) + made.of(1), 1u);
}

TEST(InteriorMaterial, MortarStandsBetweenOtherCutsAndWhatIsCrushed) {
  Solid solid = solid_of(two_materials(), {LinearColor{65535, 0, 0}, LinearColor{0, 0, 65535}});
  solid.report.parts_hollowed = 2;
  const Vec3d grey{0.5, 0.45, 0.4};
  const auto made = interior_materials({.crushed = 0.5, .mortar = grey}, solid).value();
  ASSERT_EQ(made.materials.size(), 4u);
  ASSERT_EQ(made.mortar, 2u);
  EXPECT_EQ(made.of(0, 0), 3u) << "crumbs are white";
  EXPECT_EQ(made.of(0) + made.of(1), 1u);
  EXPECT_EQ(made.cavities.size(), 2u);
  const json& mortar = made.materials[2];
  EXPECT_EQ(mortar.at("name"), "Interior_Mortar");
  EXPECT_EQ(mortar.at("pbrMetallicRoughness").at("baseColorFactor"), json({0.5, 0.45, 0.4, 1}));
  EXPECT_GE(mortar.at("pbrMetallicRoughness").at("roughnessFactor"), 0.9);
  EXPECT_EQ(interior_materials({}, solid)->mortar, kNoIndex);
}

/// `two_materials` with a change to the first material.
Mesh with_rock(float reach, const json& change) {
  Mesh mesh = two_materials(reach);
  auto library = std::make_shared<MaterialLibrary>(*mesh.library);
  library->materials[0].merge_patch(change);
  mesh.library = std::move(library);
  return mesh;
}

TEST(InteriorMaterial, WithItsTexturesAnAtlasLosesWhatTheyModulated) {
  const json material = material_of(
      {.material = "Rock"},
      with_rock(1, {{"emissiveFactor", {1, 1, 1}},
                    {"emissiveTexture", {{"index", 0}}},
                    {"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 0}}}}},
                    {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}}));
  EXPECT_FALSE(material.contains("emissiveFactor"));
  EXPECT_FALSE(material.contains("extensions"));
  EXPECT_EQ(material.at("pbrMetallicRoughness").at("metallicFactor"), 0);
  EXPECT_EQ(material.at("pbrMetallicRoughness").at("roughnessFactor"), 0.9);
}

TEST(InteriorMaterial, WhatIsOfTheWrongTypeIsNoReasonToFail) {
  for (const json& change :
       {json{{"name", 5}}, json{{"pbrMetallicRoughness", 5}},
        json{{"pbrMetallicRoughness", {{"baseColorFactor", "red"}}}},
        json{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1}}}}},
        json{{"pbrMetallicRoughness", {{"baseColorFactor", json::array()}}}},
        json{{"pbrMetallicRoughness", {{"baseColorTexture", 3}}}}, json{{"alphaMode", 7}},
        json{{"extensions", 7}}, json{{"pbrMetallicRoughness", {{"roughnessFactor", "a"}}}},
        json{{"pbrMetallicRoughness", {{"baseColorTexture", {{"texCoord", "x"}}}}}},
        json{{"pbrMetallicRoughness",
              {{"baseColorTexture", {{"extensions", {{"KHR_texture_transform", {{"scale", {"a", 1}}}}}}}}}}}})
    for (const float reach : {1.f, 4.f}) {
      const auto made = interior_materials({.material = "0", .roughness = 0.5, .opacity = 0.5, .mix = 0.5},
                                           solid_of(with_rock(reach, change), {LinearColor{65535, 0, 0}}));
      ASSERT_TRUE(made) << change;
      const json& material = made->materials.at(0);
      EXPECT_TRUE(material.at("name").is_string()) << change;
      const json& factor = material.at("pbrMetallicRoughness").at("baseColorFactor");
      ASSERT_EQ(factor.size(), 4u) << change;
      for (const json& c : factor) EXPECT_TRUE(c.is_number()) << change;
      EXPECT_EQ(material.at("pbrMetallicRoughness").at("roughnessFactor"), 0.5) << change;
    }
}

TEST(InteriorMaterial, AColorReplacesThatOfSpecularGlossiness) {
  const Mesh glossy = with_rock(
      4, {{"extensions", {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {1, 1, 1, 1}}}}}}});
  EXPECT_TRUE(material_of({.material = "Rock"}, glossy).contains("extensions"));
  EXPECT_FALSE(material_of({.material = "Rock", .color = Vec3d{1, 0, 0}}, glossy).contains("extensions"));
}

TEST(InteriorMaterial, WhereATextureLiesIsNoReasonToRepeatIt) {
  // Flipped, as exporters do it: v = 1 - v.
  EXPECT_FALSE(
      material_of(
          {.material = "Rock"},
          with_rock(1, {{"pbrMetallicRoughness",
                         {{"baseColorTexture",
                           {{"extensions",
                             {{"KHR_texture_transform", {{"offset", {0, 1}}, {"scale", {1, -1}}}}}}}}}}}))
          .contains("normalTexture"));
}

TEST(InteriorMaterial, ATextureThatIsScaledBeyondOneRepeats) {
  EXPECT_TRUE(
      material_of({.material = "Rock"},
                  with_rock(1, {{"pbrMetallicRoughness",
                                 {{"baseColorTexture",
                                   {{"extensions", {{"KHR_texture_transform", {{"scale", {3, 3}}}}}}}}}}}))
          .contains("normalTexture"));
}

TEST(InteriorMaterial, ANameGoesBeforeAnIndex) {
  EXPECT_EQ(material_of({.material = "1"}).at("doubleSided"), true);
  EXPECT_EQ(material_of({.material = "0"}).at("name"), "Interior_Rock");
}

TEST(InteriorMaterial, WhatIsAskedForReplacesWhatIsReused) {
  const json material =
      material_of({.material = "Rock", .name = "Inside", .color = Vec3d{1, 0.5, 0}, .metallic = 0.75});
  const json& pbr = material.at("pbrMetallicRoughness");
  EXPECT_EQ(material.at("name"), "Inside");
  EXPECT_EQ(pbr.at("baseColorFactor"), json({1.0, 0.5, 0.0, 1}));
  EXPECT_FALSE(pbr.contains("baseColorTexture"));
  EXPECT_EQ(pbr.at("roughnessFactor"), 0.4);
  EXPECT_EQ(pbr.at("metallicFactor"), 0.75);
}

TEST(InteriorMaterial, OpacityBelowOneBlends) {
  const json material = material_of({.opacity = 0.25});
  EXPECT_EQ(material.at("alphaMode"), "BLEND");
  EXPECT_EQ(material.at("pbrMetallicRoughness").at("baseColorFactor").at(3), 0.25);
  EXPECT_FALSE(material_of({.opacity = 1}).contains("alphaMode"));
  EXPECT_EQ(material_of({.material = "1", .opacity = 0.5}).at("pbrMetallicRoughness").at("baseColorFactor"),
            json({1, 1, 1, 0.5}));
  const Mesh masked = with_rock(4, {{"alphaMode", "MASK"}, {"alphaCutoff", 0.3}});
  EXPECT_FALSE(material_of({.material = "Rock", .opacity = 0.5}, masked).contains("alphaCutoff"));
  EXPECT_FALSE(material_of({.material = "Rock", .opacity = 1}, masked).contains("alphaMode"));
}

TEST(InteriorMaterial, ReliefIsAddedWhereThereIsNone) {
  const json plain = material_of({.detail = CutDetail::kStone});
  EXPECT_EQ(plain.at("normalTexture").at("index"), 4);
  EXPECT_EQ(plain.at("pbrMetallicRoughness").at("metallicRoughnessTexture").at("index"), 5);
  EXPECT_EQ(material_of({.material = "Rock", .detail = CutDetail::kStone}).at("normalTexture").at("index"), 1)
      << "that of the rock";
}

TEST(InteriorMaterial, AnUnknownMaterialIsRefusedWithTheNamesThereAre) {
  for (const char* name : {"rock", "2", "-1", "1x"}) {
    const auto made = interior_materials({.material = name}, solid_of(two_materials()));
    ASSERT_FALSE(made) << name;
    EXPECT_EQ(made.error().code, ErrorCode::kBadParameter);
    EXPECT_EQ(made.error().pointer, "interior_material");
    EXPECT_EQ(made.error().extra->at("known"), json({"Rock", "1"}));
  }
}

json factor_of(const InteriorMaterials& made, std::size_t part) {
  return made.materials.at(made.of(part)).at("pbrMetallicRoughness").at("baseColorFactor");
}

TEST(InteriorMaterial, PartsLookLikeTheirSurfaces) {
  const LinearColor red{65535, 0, 0}, blue{0, 0, 65535};
  const auto made =
      interior_materials({.shade = 0.5}, solid_of(two_materials(), {red, std::nullopt, blue, red}));
  ASSERT_TRUE(made);
  ASSERT_EQ(made->materials.size(), 3u);
  EXPECT_EQ(factor_of(*made, 0), json({0.5, 0.0, 0.0, 1}));
  EXPECT_EQ(made->of(0), made->of(3));
  EXPECT_EQ(factor_of(*made, 1), plain_interior_material()["pbrMetallicRoughness"]["baseColorFactor"])
      << "no colour is known";
  EXPECT_EQ(factor_of(*made, 2), json({0.0, 0.0, 0.5, 1}));
  EXPECT_EQ(made->materials[0].at("name"), "Interior") << "most parts are red";
  EXPECT_EQ(made->materials[1].at("name"), "Interior_2");
  EXPECT_EQ(made->materials[2].at("name"), "Interior_3");
}

TEST(InteriorMaterial, WhatIsTranslucentOutsideIsInsideToo) {
  Solid solid = solid_of(two_materials(), {LinearColor{65535, 0, 0}, LinearColor{65535, 0, 0}});
  solid.parts[1].translucent = true;
  const auto made = interior_materials({}, solid);
  ASSERT_TRUE(made);
  EXPECT_FALSE(made->materials.at(made->of(0)).contains("alphaMode"));
  EXPECT_EQ(made->materials.at(made->of(1)).at("alphaMode"), "BLEND");
  EXPECT_EQ(factor_of(*made, 1).at(3), kClearOpacity);
  const auto all = interior_materials({.opacity = 0.75}, solid);
  ASSERT_EQ(all->materials.size(), 1u) << "what is asked for holds for all";
  EXPECT_EQ(factor_of(*all, 0).at(3), 0.75);
}

TEST(InteriorMaterial, ColorsThatTheMixMakesAlikeAreOneMaterial) {
  const Solid solid = solid_of(two_materials(), {LinearColor{65535, 0, 0}, LinearColor{0, 0, 65535}});
  EXPECT_EQ(interior_materials({.shade = 0}, solid)->materials.size(), 1u);
  EXPECT_EQ(interior_materials({.mix = 0.01}, solid)->materials.size(), 1u);
}

TEST(InteriorMaterial, AMixWithAMaterialIsWithItsMean) {
  for (const json& factor : {json(nullptr), json{1, 1, 1, 1}}) {
    const auto made =
        interior_materials({.material = "Rock", .mix = 0.5, .shade = 1},
                           solid_of(with_rock(4, {{"pbrMetallicRoughness", {{"baseColorFactor", factor}}}}),
                                    {LinearColor{0, 0, 65535}}));
    EXPECT_EQ(factor_of(*made, 0), json({0.25, 0.125, 0.5, 1}));
    EXPECT_FALSE(made->materials[0].at("pbrMetallicRoughness").contains("baseColorTexture"));
  }
}

TEST(InteriorMaterial, AMixIsBetweenTheOutsideAndTheColorOfItsOwn) {
  const auto made = interior_materials({.color = Vec3d{0, 1, 0}, .opacity = 0.5, .mix = 0.25, .shade = 1},
                                       solid_of(two_materials(), {LinearColor{65535, 0, 0}}));
  ASSERT_TRUE(made);
  EXPECT_EQ(factor_of(*made, 0), json({0.25, 0.75, 0.0, 0.5}));
}

TEST(InteriorMaterial, WhoGivesAColorOrAMaterialOrWantsItPlainGetsIt) {
  const Solid solid = solid_of(two_materials(4), {LinearColor{65535, 0, 0}, LinearColor{0, 0, 65535}});
  for (const InteriorLook& look : {InteriorLook{.color = Vec3d{0, 1, 0}}, InteriorLook{.material = "Rock"},
                                   InteriorLook{.choice = InteriorChoice::kPlain, .mix = 1}}) {
    const auto made = interior_materials(look, solid);
    ASSERT_TRUE(made);
    ASSERT_EQ(made->materials.size(), 1u);
    EXPECT_TRUE(made->of_part.empty());
  }
}

TEST(InteriorMaterial, ThereAreAtMostSixteen) {
  std::vector<std::optional<LinearColor>> colors{std::nullopt};
  for (int r = 0; r < 5; ++r)
    for (int g = 0; g < 5; ++g)
      colors.push_back(
          LinearColor{static_cast<std::uint16_t>(16383 * r), static_cast<std::uint16_t>(16383 * g), 0});
  const auto made = interior_materials({}, solid_of(two_materials(), colors));
  ASSERT_TRUE(made);
  EXPECT_LE(made->materials.size(), kMostInteriorMaterials);
  EXPECT_GT(made->materials.size(), kMostInteriorMaterials / 2);
  for (std::size_t part = 0; part < colors.size(); ++part) EXPECT_LT(made->of(part), made->materials.size());
}

TEST(InteriorMaterial, MapsThatAReaderHasAreLeftOutButCutsLieUnderThem) {
  const InteriorLook all{.crushed = 0.1, .mortar = Vec3d{1, 1, 1}, .detail = CutDetail::kStone};
  InteriorLook rest = all;
  rest.has_maps = true;
  const auto first = interior_materials(all, solid_of(two_materials())).value();
  const auto later = interior_materials(rest, solid_of(two_materials())).value();
  EXPECT_EQ(first.detail, CutDetail::kStone);
  EXPECT_TRUE(first.materials[0].contains("normalTexture"));
  EXPECT_EQ(later.detail, CutDetail::kNone);
  EXPECT_FALSE(later.materials[0].contains("normalTexture"));
  ASSERT_EQ(first.materials.size(), 3u);
  EXPECT_EQ(first.in_relief, 1u) << "not mortar, nor what is crushed";
  EXPECT_EQ(later.in_relief, 1u);
  EXPECT_EQ(interior_materials({}, solid_of(two_materials())).value().in_relief, 0u);
}

}  // namespace
}  // namespace fracture
