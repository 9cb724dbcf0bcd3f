// The high tier, judged by which points must be brighter than others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/client/models.hpp"
#include "tests/client/renderer_fixture.hpp"

namespace fracture::test {
namespace {

using namespace fracture::render;

RenderSettings high(RenderSettings settings) {
  settings.tier = Tier::kHigh;
  return settings;
}

Camera looking(const glm::vec3& eye, const glm::vec3& target) {
  Camera camera;
  camera.eye = eye;
  camera.view = glm::lookAt(eye, target, glm::vec3(0, 1, 0));
  camera.projection = glm::perspective(glm::radians(50.f), 1.f, 0.05f, 300.f);
  return camera;
}

// -- ambient occlusion

/// A floor and a wall that meet at z = 0, lit only by the sky.
struct Crease {
  Model model;
  Camera camera = looking({0, 1.5f, 2.5f}, {0, 0, 0.3f});
  RenderSettings settings;

  explicit Crease(RenderSettings bare) : settings(std::move(bare)) {
    model.materials = {paint({0.5f, 0.5f, 0.5f})};
    add_box(model, {0, -0.1f, 0}, {4, 0.2f, 4});
    add_box(model, {0, 0.5f, -0.1f}, {4, 1, 0.2f});
    settings.lighting.sun = glm::vec3(0);
    settings.lit = Sphere{{0, 0, 0}, 3};
  }
};

TEST_F(RendererTest, HighACreaseIsDarkerAndAPlaneIsNot) {
  const Crease c(bare());
  const auto floor_at = [&](const Picture& picture, float x, float z) {
    return luminance(pixel_at(picture, c.camera, {x, 0, z}));
  };
  const Picture low = draw(c.model, c.camera, c.settings);
  EXPECT_NEAR(floor_at(low, 0, 0.03f), floor_at(low, 0, 1.2f), 0.02 * floor_at(low, 0, 1.2f));
  const Picture picture = draw(c.model, c.camera, high(c.settings));
  EXPECT_EQ(stats.tier, Tier::kHigh);
  const double open = floor_at(picture, 0, 1.2f);
  EXPECT_LT(floor_at(picture, 0, 0.03f), 0.8 * open);
  // The darkening ends where the wall is farther away than the radius, which is 0.12 of 3 m.
  EXPECT_NEAR(floor_at(picture, 0, 0.5f), open, 0.04 * open);
  for (float x = -0.6f; x <= 0.6f; x += 0.1f)
    for (float z = 0.6f; z <= 1.4f; z += 0.1f)
      EXPECT_NEAR(floor_at(picture, x, z), open, 0.03 * open) << x << ", " << z;
}

TEST_F(RendererTest, HighAnEdgeBeforeTheSkyHasNoHalo) {
  Model model;
  model.materials = {paint({0.5f, 0.5f, 0.5f})};
  add_box(model, {0, 0, 0}, {1, 1, 1});
  RenderSettings settings = bare();
  settings.lighting.sun = glm::vec3(0);
  const Camera camera = straight(0, 0);
  const Picture picture = draw(model, camera, high(settings));
  const double middle = luminance(pixel_at(picture, camera, {0, 0, 0.5f}));
  for (const float x : {-0.48f, -0.45f, 0.45f, 0.48f})
    EXPECT_NEAR(luminance(pixel_at(picture, camera, {x, 0.1f, 0.5f})), middle, 0.02 * middle) << x;
}

// -- shadows

TEST_F(RendererTest, SoftShadowsHaveNoPattern) {
  Model model;
  model.materials = {paint({0.5f, 0.5f, 0.5f})};
  add_box(model, {0, 0.5f, 0}, {0.5f, 1, 2});
  RenderSettings settings = bare();
  settings.ground = Ground::kNone;
  add_box(model, {0, -0.1f, 0}, {6, 0.2f, 6});
  settings.lighting.towards_sun = {1, 1, 0};
  settings.lit = Sphere{{0, 0, 0}, 6};
  settings.lighting.sun_softness = 6;
  const Camera camera = looking({-1.2f, 2, 0.01f}, {-1.2f, 0, 0});
  // The shadow of the top's edge is at x = -1.25. Neighbours along it get the same light.
  const auto noise = [&](const Picture& picture) {
    double sum = 0;
    int count = 0;
    for (float x = -1.27f; x < -1.23f; x += 0.005f)
      for (float z = -0.4f; z <= 0.4f; z += 0.01f) {
        sum += std::abs(luminance(pixel_at(picture, camera, {x, 0, z})) -
                        luminance(pixel_at(picture, camera, {x, 0, z + 0.005f})));
        ++count;
      }
    return sum / count;
  };
  // Samples that are rotated from pixel to pixel gave more than 0.003.
  EXPECT_LT(noise(draw(model, camera, settings, 400, 400)), 0.001);
  EXPECT_LT(noise(draw(model, camera, high(settings), 400, 400)), 0.001);
}

TEST_F(RendererTest, HighGlassThrowsAnEvenFaintShadow) {
  Material glass = paint({1, 1, 1});
  glass.transmission = 1;
  Model model;
  model.materials = {paint({0.5f, 0.5f, 0.5f}), glass};
  add_box(model, {0, -0.1f, 0}, {6, 0.2f, 6}, 0);
  add_box(model, {0, 1, 0}, {1, 0.05f, 1}, 1);
  RenderSettings settings = bare();
  settings.lighting.towards_sun = {1, 1, 0};
  settings.lit = Sphere{{0, 0, 0}, 3};
  const Camera camera = looking({-1, 2, 2.2f}, {-1, 0, 0});
  const Picture picture = draw(model, camera, high(settings));
  const double lit = luminance(pixel_at(picture, camera, {-2, 0, 0}));
  double least = 1, most = 0;
  for (float x = -1.25f; x <= -0.75f; x += 0.05f) {
    const double y = luminance(pixel_at(picture, camera, {x, 0, 0.2f}));
    least = std::min(least, y);
    most = std::max(most, y);
  }
  EXPECT_LT(most, 0.9 * lit);
  EXPECT_GT(least, 0.5 * lit);
  EXPECT_NEAR(least, most, 0.02 * most);
}

// -- sky

TEST_F(RendererTest, HighAMirrorShowsTheColourOfTheHorizon) {
  Material mirror = paint({1, 1, 1});
  mirror.metallic = 1;
  mirror.roughness = 0;
  Model model;
  model.materials = {mirror};
  add_box(model, {0, 1, 0}, {1, 1, 0.2f});
  RenderSettings settings = bare();
  settings.background = true;
  settings.lighting.towards_sun = {0, 1, -0.2f};  // not into the mirror
  const Camera camera = looking({0, 1, 4}, {0, 1, 0});
  const Picture picture = draw(model, camera, high(settings));
  const Color mirrored = pixel_at(picture, camera, {0, 1, 0.1f}),
              horizon = pixel_at(picture, camera, {1.2f, 1.02f, 0.1f}),
              above = pixel_at(picture, camera, {1.2f, 2.2f, 0.1f});
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(linear(mirrored[k]), linear(horizon[k]), 0.1 * linear(horizon[k])) << k;
  // It differs from the colour of the sky above, which is bluer.
  EXPECT_GT(linear(above[2]) / linear(above[0]), 1.3 * linear(horizon[2]) / linear(horizon[0]));
}

TEST_F(RendererTest, HighARoughMirrorShowsLessOfIt) {
  Material metal = paint({1, 1, 1});
  metal.metallic = 1;
  RenderSettings settings = bare();
  settings.lighting.sun = glm::vec3(0);
  // The camera looks straight at the upright mirror. From the lower to the upper end of the mirror, the reflected direction
  // crosses the horizon.
  const Camera camera = looking({0, 0, 3}, {0, 0, 0});
  const auto contrast = [&](float roughness) {
    Model model;
    metal.roughness = roughness;
    model.materials = {metal};
    add_box(model, {0, 0, 0}, {1.6f, 1.6f, 0.1f});
    const Picture picture = draw(model, camera, high(settings));
    return std::abs(luminance(pixel_at(picture, camera, {0, 0.7f, 0.05f})) -
                    luminance(pixel_at(picture, camera, {0, -0.7f, 0.05f})));
  };
  EXPECT_LT(contrast(0.8f), 0.7 * contrast(0));
}

TEST_F(RendererTest, HighFarGroundHasTheColourOfTheHorizon) {
  Model model;
  model.materials = {paint({0.5f, 0.5f, 0.5f})};
  add_box(model, {0, 0.5f, 0}, {0.2f, 1, 0.2f});
  RenderSettings settings = bare();
  settings.ground = Ground::kGrid;
  settings.ground_height = 0.f;
  settings.background = true;
  settings.lit = Sphere{{0, 0, 0}, 5};
  const Camera camera = looking({3, 2, 8}, {3, 2, 0});
  const Picture picture = draw(model, camera, high(settings), 300, 300);
  // The middle of the picture is at eye level; six rows are a degree.
  const Color above = picture.at(100, 148), below = picture.at(100, 153), near = picture.at(100, 290);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(below[k], above[k], 5) << k;
  EXPECT_LT(luminance(near), 0.8 * luminance(above));
}

// -- glass

TEST_F(RendererTest, HighGlassBendsWhatIsBehindIt) {
  Material glass = paint({1, 1, 1}), red = paint({0, 0, 0}), blue = paint({0, 0, 0});
  glass.transmission = 1;
  glass.roughness = 0;
  red.emissive = {0.6f, 0, 0};
  blue.emissive = {0, 0, 0.6f};
  Model model;
  model.materials = {red, blue, glass};
  add_box(model, {-1, 0, -1}, {2, 2, 0.1f}, 0);
  add_box(model, {1, 0, -1}, {2, 2, 0.1f}, 1);
  add_box(model, {0, 0, 0}, {1.6f, 1.2f, 0.5f}, 2);
  auto states = initial_states(model);
  states[2].transform = glm::rotate(glm::mat4(1), glm::radians(45.f), glm::vec3(0, 1, 0));
  RenderSettings settings = bare();
  settings.lighting.sun = settings.lighting.sky = settings.lighting.ground = glm::vec3(0);
  const Camera camera = straight(0, 0, true, {{0, 0, 0}, 1});
  // A plate of 0.5 m at 45° moves the ray by t sin a (1 - cos a / (n cos b)) = 0.165 m, here to the left.
  const Picture low = draw(model, camera, settings, 300, 300, states),
                picture = draw(model, camera, high(settings), 300, 300, states);
  const auto is_red = [&](const Picture& seen, float x) {
    const Color c = pixel_at(seen, camera, {x, 0, 0});
    EXPECT_GT(std::max(linear(c[0]), linear(c[2])), 0.15) << x;
    return linear(c[0]) > linear(c[2]);
  };
  for (const float x : {0.03f, 0.08f, 0.13f}) {
    EXPECT_FALSE(is_red(low, x)) << x;
    EXPECT_TRUE(is_red(picture, x)) << x;
  }
  for (const float x : {0.20f, 0.30f}) EXPECT_FALSE(is_red(picture, x)) << x;
  for (const float x : {-0.03f, -0.3f}) EXPECT_TRUE(is_red(picture, x)) << x;
}

TEST_F(RendererTest, HighGlassBehindGlassIsSeen) {
  Material clear = paint({1, 1, 1}), green = paint({0.1f, 1, 0.1f});
  clear.transmission = green.transmission = 1;
  clear.roughness = green.roughness = 0;
  Material glow = paint({0, 0, 0});
  glow.emissive = {0.6f, 0.6f, 0.6f};
  Model model;
  model.materials = {glow, clear, green};
  add_box(model, {0, 0, -1}, {2, 2, 0.1f}, 0);
  add_box(model, {0, 0, -0.3f}, {0.5f, 0.5f, 0.05f}, 2);
  add_box(model, {0, 0, 0.3f}, {1, 1, 0.05f}, 1);
  RenderSettings settings = bare();
  settings.lighting.sun = settings.lighting.sky = settings.lighting.ground = glm::vec3(0);
  const Camera camera = straight(0, 0, true, {{0, 0, 0}, 1});
  const Picture picture = draw(model, camera, high(settings));
  const Color both = pixel_at(picture, camera, {0, 0, 0}), one = pixel_at(picture, camera, {0.4f, 0, 0}),
              none = pixel_at(picture, camera, {0.8f, 0, 0});
  EXPECT_GT(linear(both[1]), 2 * linear(both[0]));
  EXPECT_NEAR(linear(one[1]), linear(one[0]), 0.02);
  EXPECT_GT(luminance(one), 0.8 * luminance(none));
}

TEST_F(RendererTest, CutsThatHoldAreNotDrawn) {
  Model model;
  model.materials = {paint({0.1f, 0.1f, 0.8f}), paint({0.1f, 0.8f, 0.1f})};
  model.materials[1].interior = true;
  add_box(model, {0, 0, 0}, glm::vec3(1), {0, 0, 0, 0, 1, 0});  // the face at +z is a cut
  sort_by_material(model);
  auto gpu = GpuModel::upload(std::make_shared<const Model>(model));
  auto target = FrameTarget::create(300, 300);
  ASSERT_TRUE(gpu && target);
  const auto states = initial_states(model);
  const std::vector<std::uint8_t> held = {1};
  const auto seen = [&](std::span<const std::uint8_t> uncut, const RenderSettings& settings) {
    const DrawItem item{.model = &*gpu, .states = states, .uncut = uncut};
    renderer->draw(std::span(&item, 1), straight(0, 0), settings, target->framebuffer(), 300, 300);
    return coverage(target->read());
  };
  for (const RenderSettings& settings : {bare(), high(bare())}) {
    EXPECT_NEAR(seen({}, settings), 1.0 / 3, 0.01);
    EXPECT_EQ(seen(held, settings), 0);
  }
}

// -- the whole picture

/// The light next to a small square that emits or reflects light.
double beside_a_square(const Picture& picture) {
  double sum = 0;
  for (int x = 175; x < 190; ++x) sum += luminance(picture.at(x, 150));
  return sum / 15;
}

TEST_F(RendererTest, HighAGlintBloomsAndWhiteDoesNot) {
  const Camera camera = straight(0, 0, true, {{0, 0, 0}, 1});
  const auto beside = [&](const glm::vec3& color, const glm::vec3& emissive) {
    Model model;
    Material m = paint(color);
    m.emissive = emissive;
    model.materials = {m};
    add_box(model, {0, 0, 0}, {0.2f, 0.2f, 0.1f});  // 30 pixels wide, in the middle of 300
    RenderSettings settings = bare();
    settings.lighting.towards_sun = {0.3f, 0.3f, 1};  // at its front
    const Picture picture = draw(model, camera, high(settings));
    EXPECT_GT(luminance(picture.at(150, 150)), 0.5);
    return beside_a_square(picture);
  };
  EXPECT_LT(beside(glm::vec3(0.9f), glm::vec3(0)), 1e-6);
  EXPECT_GT(beside(glm::vec3(0), glm::vec3(12)), 0.003);
  EXPECT_LT(beside(glm::vec3(0), glm::vec3(12)), 0.2) << "restrained";
}

TEST_F(RendererTest, HighAnEdgeHasPixelsInBetween) {
  Model model;
  Material glow = paint({0, 0, 0});
  glow.emissive = glm::vec3(0.7f);
  model.materials = {glow};
  add_box(model, {0, 0, 0}, {1, 1, 0.1f});
  auto states = initial_states(model);
  states[0].transform = glm::rotate(glm::mat4(1), glm::radians(12.f), glm::vec3(0, 0, 1));
  RenderSettings settings = bare();
  settings.lighting.sky = settings.lighting.ground = settings.lighting.sun = glm::vec3(0);
  const Picture picture = draw(model, straight(0, 0, true, {{0, 0, 0}, 1}), high(settings), 300, 300, states);
  const double full = luminance(picture.at(150, 150));
  int rows = 0, smooth = 0;
  for (int y = 110; y < 190; ++y) {
    bool between = false;
    for (int x = 150; x < 299; ++x) {
      const double here = luminance(picture.at(x, y));
      between = between || (here > 0.1 * full && here < 0.9 * full);
    }
    ++rows;
    smooth += between;
  }
  EXPECT_GT(smooth, 0.9 * rows);
}

TEST_F(RendererTest, HighTheSamePictureTwiceAndLowAfterItAsBefore) {
  const Model model = cube_of_fragments(3);
  const Camera camera = straight(30, 20, false);
  const Picture low = draw(model, camera, {});
  const FrameStats of_low = stats;
  const Picture first = draw(model, camera, high({}));
  EXPECT_NE(first.pixels, low.pixels);
  EXPECT_EQ(draw(model, camera, high({})).pixels, first.pixels);
  EXPECT_EQ(draw(model, camera, {}).pixels, low.pixels);
  EXPECT_EQ(stats.draw_calls, of_low.draw_calls);
  EXPECT_EQ(stats.shadow_draw_calls, of_low.shadow_draw_calls);
}

TEST_F(RendererTest, HighOfAnySize) {
  for (const auto& [width, height] : {std::pair(16, 16), std::pair(333, 77), std::pair(64, 1)})
    EXPECT_GT(coverage(draw(red_cube(), straight(30, 20), high({}), width, height)), 0.99) << width;
}

TEST_F(RendererTest, EdgesAloneAreDrawnLow) {
  RenderSettings settings = high(bare());
  settings.wireframe = true;
  draw(red_cube(), straight(30, 20), settings);
  EXPECT_EQ(stats.tier, Tier::kLow);
}

}  // namespace
}  // namespace fracture::test
