#include "common/surface_color/base_color.hpp"
#include "common/mesh/material_library.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace fracture {
namespace {

using nlohmann::json;

MaterialLibrary library_of(json material) {
  MaterialLibrary library;
  library.materials.push_back(std::move(material));
  library.textures = {{{"source", 0}, {"sampler", 0}}, {{"source", 9}}};
  library.samplers = {{{"wrapS", 33071}, {"wrapT", 33648}}};
  library.images.resize(1);
  return library;
}

TEST(BaseColor, HasFactorTextureAndWrap) {
  const BaseColor color = base_color(library_of({{"pbrMetallicRoughness",
                                                  {{"baseColorFactor", {0.5, 0.25, 2, 1}},
                                                   {"baseColorTexture", {{"index", 0}, {"texCoord", 1}}}}},
                                                 {"alphaMode", "MASK"}}),
                                     0);
  EXPECT_EQ(color.factor, (Vec3d{0.5, 0.25, 1})) << "not above 1";
  ASSERT_TRUE(color.texture);
  EXPECT_EQ(color.texture->uv_set, 1u);
  EXPECT_EQ(color.texture->wrap, (std::array{Wrap::kClamp, Wrap::kMirror}));
  EXPECT_TRUE(color.weigh_opacity);
}

TEST(BaseColor, OfSpecularGlossinessIsTheDiffuseColor) {
  const BaseColor color = base_color(
      library_of({{"extensions",
                   {{"KHR_materials_pbrSpecularGlossiness",
                     {{"diffuseFactor", {0.1, 0.2, 0.3, 1}}, {"diffuseTexture", {{"index", 0}}}}}}}}),
      0);
  EXPECT_EQ(color.factor, (Vec3d{0.1, 0.2, 0.3}));
  EXPECT_TRUE(color.texture);
}

TEST(BaseColor, AnImageInAnExtensionOfTheTextureIsItsImage) {
  MaterialLibrary library = library_of({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}}});
  EXPECT_FALSE(base_color(library, 0).texture);
  library.textures[1] = {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}};
  EXPECT_TRUE(base_color(library, 0).texture);
}

TEST(BaseColor, LightComesThroughWhatIsBlendedOrTransmits) {
  EXPECT_FALSE(base_color(library_of({{"alphaMode", "MASK"}}), 0).translucent);
  EXPECT_TRUE(base_color(library_of({{"alphaMode", "BLEND"}}), 0).translucent);
  const auto transmitting = [](double factor) {
    return json{{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", factor}}}}}};
  };
  EXPECT_TRUE(base_color(library_of(transmitting(0.9)), 0).translucent);
  EXPECT_FALSE(base_color(library_of(transmitting(0)), 0).translucent);
}

TEST(BaseColor, WhatIsNotAllowedIsNotThere) {
  for (const json& pbr :
       {json(3), json{{"baseColorFactor", "red"}}, json{{"baseColorFactor", {1, 1}}},
        json{{"baseColorTexture", {{"index", 1}}}}, json{{"baseColorTexture", {{"index", -1}}}},
        json{{"baseColorTexture", {{"index", 7}}}}, json{{"baseColorTexture", json::array()}}}) {
    const BaseColor color = base_color(library_of({{"pbrMetallicRoughness", pbr}}), 0);
    EXPECT_EQ(color.factor, (Vec3d{1, 1, 1})) << pbr;
    EXPECT_FALSE(color.texture) << pbr;
  }
  EXPECT_EQ(base_color(MaterialLibrary{}, 0).factor, (Vec3d{1, 1, 1}));
}

TEST(BaseColor, TransformScalesThenTurnsThenMoves) {
  const BaseColor color = base_color(library_of({{"pbrMetallicRoughness",
                                                  {{"baseColorTexture",
                                                    {{"index", 0},
                                                     {"extensions",
                                                      {{"KHR_texture_transform",
                                                        {{"offset", {0.5, 0}},
                                                         {"rotation", std::numbers::pi / 2},
                                                         {"scale", {2, 3}},
                                                         {"texCoord", 2}}}}}}}}}}),
                                     0);
  ASSERT_TRUE(color.texture);
  EXPECT_EQ(color.texture->uv_set, 2u);
  // (1, 0) becomes (2, 0). Turned counter-clockwise, with v pointing down, it becomes (0, -2).
  EXPECT_EQ(color.texture->place({1, 0}), (std::array{0.5, -2.0}));
  EXPECT_EQ(color.texture->place({0, 1}), (std::array{3.5, 0.0}));
}

TEST(Wrapped, EveryCoordinateHasAPixel) {
  EXPECT_EQ(wrapped(0.3, Wrap::kRepeat, 10), 3u);
  EXPECT_EQ(wrapped(-0.05, Wrap::kRepeat, 10), 9u);
  EXPECT_EQ(wrapped(7.25, Wrap::kRepeat, 10), 2u);
  EXPECT_EQ(wrapped(1.25, Wrap::kMirror, 10), 7u);
  EXPECT_EQ(wrapped(-0.25, Wrap::kMirror, 10), 2u);
  EXPECT_EQ(wrapped(-3, Wrap::kClamp, 10), 0u);
  EXPECT_EQ(wrapped(3, Wrap::kClamp, 10), 9u);
  const double huge = std::numeric_limits<double>::max();
  for (const Wrap wrap : {Wrap::kRepeat, Wrap::kMirror, Wrap::kClamp})
    for (const double x : {huge, -huge, HUGE_VAL, -HUGE_VAL, std::nan(""), 1.0, -1e-300})
      EXPECT_LT(wrapped(x, wrap, 10), 10u) << x;
}

}  // namespace
}  // namespace fracture
