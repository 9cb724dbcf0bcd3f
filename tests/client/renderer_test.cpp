// The positions of objects in a picture, judged by geometry computed by hand, not by stored pixels.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "client/render/fragment_views.hpp"
#include "tests/client/models.hpp"
#include "tests/client/renderer_fixture.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::test {
namespace {

using namespace fracture::render;

// The picture is as wide as the sphere's diameter, √3.
TEST_F(RendererTest, AUnitCubeCoversItsProjectedArea) {
  const double picture_area = 3;
  EXPECT_NEAR(coverage(draw(red_cube(), straight(0, 0), bare())), 1 / picture_area, 0.01 / picture_area);
  EXPECT_NEAR(coverage(draw(red_cube(), straight(45, 0), bare())), std::sqrt(2.0) / picture_area,
              0.01 * std::sqrt(2.0) / picture_area);
  // Along a diagonal it is a regular hexagon of area √3.
  const auto elevation = static_cast<float>(std::atan(1 / std::sqrt(2.0)) * 180 / 3.14159265358979);
  EXPECT_NEAR(coverage(draw(red_cube(), straight(45, elevation), bare())), std::sqrt(3.0) / picture_area,
              0.01 * std::sqrt(3.0) / picture_area);
}

TEST_F(RendererTest, PerspectiveShowsTheFrontFaceAtItsDistance) {
  const Camera camera = straight(0, 0, false);
  const double distance = camera.eye.z,
               half_height = std::tan(15 * 3.14159265358979 / 180) * (distance - 0.5);
  const double expected = std::pow(0.5 / half_height, 2);
  EXPECT_NEAR(coverage(draw(red_cube(), camera, bare())), expected, 0.01 * expected);
}

TEST_F(RendererTest, ARedCubeIsRed) {
  const Picture picture = draw(red_cube(), straight(30, 20), bare());
  for (const Color& c : picture.pixels) {
    if (c[3] < 255) continue;
    EXPECT_GT(linear(c[0]), 3 * linear(c[1]));
    EXPECT_GT(linear(c[0]), 3 * linear(c[2]));
    EXPECT_GT(c[0], 25);
  }
}

TEST_F(RendererTest, TheSamePictureTwice) {
  const Model model = cube_of_fragments(3);
  const Camera camera = straight(30, 20);
  EXPECT_EQ(draw(model, camera, {}).pixels, draw(model, camera, {}).pixels);
}

TEST_F(RendererTest, ExplodedFragmentsCoverMoreThanAssembledOnes) {
  const Model model = cube_of_fragments(2);
  ViewOptions options;
  options.view = View::kExploded;
  options.explode = 0.6f;
  const auto exploded = view_states(model, options, {});
  const Camera camera = straight(35, 25, true, bounding_sphere(model, exploded));
  const double together = coverage(draw(model, camera, bare()));
  const double apart = coverage(draw(model, camera, bare(), 300, 300, exploded));
  EXPECT_GT(apart, 1.2 * together);
  // Together, the eight fragments are the cube.
  EXPECT_NEAR(together, coverage(draw(red_cube(), camera, bare())), 0.002);
}

TEST_F(RendererTest, StraightOnExplodedFragmentsShowTheirOwnFaces) {
  const Model model = cube_of_fragments(2);
  ViewOptions options;
  options.view = View::kExploded;
  options.explode = 1;
  const auto states = view_states(model, options, {});
  // Four faces of side 1/2 in front, and the other four exactly behind them, in a picture of side 2 · 2.
  const double seen = coverage(draw(model, straight(0, 0, true, {{0, 0, 0}, 2}), bare(), 400, 400, states));
  EXPECT_NEAR(seen, 1.0 / 16, 0.01 / 16);
}

TEST_F(RendererTest, HiddenObjectsAreNotDrawn) {
  const Model model = cube_of_fragments(2);
  auto states = initial_states(model);
  for (std::size_t k = 0; k < states.size(); ++k) states[k].visible = k % 2 == 0;  // the slab at small x
  const double seen = coverage(draw(model, straight(0, 0), bare(), 300, 300, states));
  EXPECT_NEAR(seen, 0.5 / 3, 0.01);
  EXPECT_EQ(stats.surfaces, 24u);
}

// -- textures and materials

std::string square_with_picture(const Picture& picture, const nlohmann::json& material_extra,
                                const nlohmann::json& node = nlohmann::json::object()) {
  const TemporaryFolder folder;
  EXPECT_TRUE(write_png(picture, folder / "t.png"));
  std::ifstream in(folder / "t.png", std::ios::binary);
  const std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(in), {}};
  GltfPrimitive p;
  p.positions = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};
  p.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  p.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};  // v down: the picture's upper left corner is at (-0.5, 0.5)
  p.indices = {0, 1, 2, 0, 2, 3};
  p.material = 0;
  nlohmann::json material = {
      {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0}}}};
  material.update(material_extra);
  return gltf_text(
      {p}, node,
      {{"materials", {material}},
       {"textures", {{{"source", 0}, {"sampler", 0}}}},
       {"samplers", {{{"magFilter", 9728}, {"minFilter", 9728}}}},
       {"images", {{{"uri", "data:image/png;base64," + base64(bytes)}, {"mimeType", "image/png"}}}}});
}

Model read(const std::string& text) {
  auto model = read_model(std::as_bytes(std::span(text)));
  if (!model) throw std::runtime_error(model.error().detail);
  return std::move(*model);
}

const Picture& four_colors() {
  static const Picture picture = [] {
    Picture p(2, 2);
    p.at(0, 0) = {255, 0, 0, 255};
    p.at(1, 0) = {0, 255, 0, 255};
    p.at(0, 1) = {0, 0, 255, 255};
    p.at(1, 1) = {255, 255, 255, 255};
    return p;
  }();
  return picture;
}

/// Which channels are bright: 'r', 'g', 'b', 'w' or '.'.
char name_of(const Color& c) {
  const bool r = c[0] > 90, g = c[1] > 90, b = c[2] > 90;
  return r && g && b ? 'w' : r && !g && !b ? 'r' : g && !r && !b ? 'g' : b && !r && !g ? 'b' : '.';
}

std::string corners(const Picture& picture, const Camera& camera) {
  std::string names;
  for (const glm::vec3 p : {glm::vec3(-0.25, 0.25, 0), glm::vec3(0.25, 0.25, 0), glm::vec3(-0.25, -0.25, 0),
                            glm::vec3(0.25, -0.25, 0)})
    names += name_of(pixel_at(picture, camera, p));
  return names;
}

TEST_F(RendererTest, ATextureLandsTheRightWayRound) {
  const Model model = read(square_with_picture(four_colors(), nlohmann::json::object()));
  EXPECT_EQ(corners(draw(model, straight(0, 0), bare()), straight(0, 0)), "rgbw");
}

TEST_F(RendererTest, AMirroredNodeIsMirroredAndNotInsideOut) {
  const Model model =
      read(square_with_picture(four_colors(), nlohmann::json::object(), {{"scale", {-1, 1, 1}}}));
  EXPECT_EQ(corners(draw(model, straight(0, 0), bare()), straight(0, 0)),
            "grwb");                                              // seen from the front, sides swapped
  EXPECT_EQ(coverage(draw(model, straight(180, 0), bare())), 0);  // and not from behind
}

TEST_F(RendererTest, OneSidedSurfacesAreSeenFromTheirFrontDoubleSidedOnesFromBoth) {
  const Model one = read(square_with_picture(four_colors(), nlohmann::json::object()));
  const Model both = read(square_with_picture(four_colors(), {{"doubleSided", true}}));
  EXPECT_NEAR(coverage(draw(one, straight(0, 0), bare())), 1.0 / 3, 0.01);
  EXPECT_EQ(coverage(draw(one, straight(180, 0), bare())), 0);
  EXPECT_NEAR(coverage(draw(both, straight(180, 0), bare())), 1.0 / 3, 0.01);
  EXPECT_EQ(corners(draw(both, straight(180, 0), bare()), straight(180, 0)),
            "rgbw");  // the same points in the world
}

TEST_F(RendererTest, AMaskCutsWhereAlphaIsBelowItsCutoff) {
  Picture picture(2, 2, {200, 200, 200, 255});
  picture.at(0, 0)[3] = 100;  // below the cutoff of 0.5
  picture.at(1, 1)[3] = 140;  // above
  // write_png drops alpha, so this texture is opaque; the masked copy below gets its alpha by hand.
  const Model opaque = read(square_with_picture(picture, {{"alphaMode", "MASK"}}));
  EXPECT_NEAR(coverage(draw(opaque, straight(0, 0), bare())), 1.0 / 3, 0.01);
  Model masked = opaque;
  for (Picture& p : masked.pictures) {
    p.at(0, 0)[3] = 100;
    p.at(1, 1)[3] = 140;
  }
  EXPECT_NEAR(coverage(draw(masked, straight(0, 0), bare())), 0.75 / 3, 0.01);
  masked.materials[0].alpha_cutoff = 0.6f;
  EXPECT_NEAR(coverage(draw(masked, straight(0, 0), bare())), 0.5 / 3, 0.01);
}

TEST_F(RendererTest, ANormalMapBendsTheLightTheRightWay) {
  // The colour (1, 0.5, 0.5) approximately tilts the normal to +x (tangent, u to the right); green tilts it
  // upwards: glTF 2.0, 3.9.3.
  const auto brightness = [&](Color normal, glm::vec3 towards_sun) {
    Model model = read(square_with_picture(Picture(2, 2, {200, 200, 200, 255}), nlohmann::json::object()));
    model.pictures.push_back(Picture(2, 2, normal));
    model.materials[0].normal_texture.picture = 1;
    RenderSettings settings = bare();
    settings.lighting.sky = settings.lighting.ground = glm::vec3(0);
    settings.lighting.towards_sun = towards_sun;
    settings.lighting.sun_shadow = false;
    return luminance(pixel_at(draw(model, straight(0, 0), settings), straight(0, 0), {0.1f, 0.1f, 0}));
  };
  const Color right = {218, 128, 218, 255}, left = {38, 128, 218, 255}, up = {128, 218, 218, 255},
              down = {128, 38, 218, 255};
  EXPECT_GT(brightness(right, {1, 0, 1}), 1.5 * brightness(left, {1, 0, 1}));
  EXPECT_GT(brightness(left, {-1, 0, 1}), 1.5 * brightness(right, {-1, 0, 1}));
  EXPECT_GT(brightness(up, {0, 1, 1}), 1.5 * brightness(down, {0, 1, 1}));
  EXPECT_GT(brightness(down, {0, -1, 1}), 1.5 * brightness(up, {0, -1, 1}));
}

// -- how much is submitted

TEST_F(RendererTest, FiveHundredFragmentsOfTwoMaterialsAreTwoDrawCalls) {
  Model model;
  model.materials = {paint({0.5f, 0.5f, 0.5f}), paint({0.6f, 0.3f, 0.2f})};
  for (int k = 0; k < 500; ++k)
    add_box(model, {static_cast<float>(k % 10), static_cast<float>(k / 10 % 10), static_cast<float>(k / 100)},
            glm::vec3(0.8f), {0, 0, 0, 0, 1, 1});
  sort_by_material(model);
  const Sphere sphere = bounding_sphere(model, {});
  const Picture picture = draw(model, straight(30, 20, true, sphere), bare());
  EXPECT_EQ(stats.draw_calls, 2u);
  EXPECT_EQ(stats.surfaces, 3000u);
  EXPECT_EQ(stats.culled, 0u);
  EXPECT_GT(coverage(picture), 0.2);
}

TEST_F(RendererTest, WhatIsOutOfSightIsCulled) {
  Model model;
  model.materials = {paint({0.5f, 0.5f, 0.5f})};
  add_box(model, {0, 0, 0}, glm::vec3(1));
  add_box(model, {50, 0, 0}, glm::vec3(1));
  const double seen = coverage(draw(model, straight(0, 0), bare()));
  EXPECT_NEAR(seen, 1.0 / 3, 0.01);
  EXPECT_EQ(stats.surfaces, 6u);
  EXPECT_EQ(stats.culled, 6u);
}

TEST_F(RendererTest, APictureTooLargeForTheDriverIsRefused) {
  const auto target = FrameTarget::create(1 << 20, 16);
  ASSERT_FALSE(target);
  EXPECT_EQ(target.error().code, ErrorCode::kTooLarge);
  EXPECT_FALSE(FrameTarget::create(0, 16));
}

}  // namespace
}  // namespace fracture::test
