// Light, shadow, transparency and highlights, judged by which points must be brighter than others.
#include <gtest/gtest.h>

#include <cmath>

#include "client/render/fragment_views.hpp"
#include "tests/client/models.hpp"
#include "tests/client/renderer_fixture.hpp"

namespace fracture::test {
namespace {

using namespace fracture::render;

/// A pillar on the ground at the origin, and a camera high enough to see around it.
struct Pillar {
  Model model;
  Camera camera;
  RenderSettings settings;

  Pillar() {
    model.materials = {paint({0.5f, 0.5f, 0.5f})};
    add_box(model, {0, 0.5f, 0}, {0.5f, 1, 0.5f});
    CameraPlacement placement;
    placement.yaw = 0;
    placement.pitch = 60;
    camera = fit_camera({{0, 0.25f, 0}, 2}, placement, 1);
    settings.ground_height = 0.f;
    settings.lighting.towards_sun = {1, 1, 0};
    settings.lighting.sky_shadows = 0;
  }
};

TEST_F(RendererTest, AShadowFallsOnTheSideAwayFromTheLight) {
  Pillar p;
  const Picture picture = draw(p.model, p.camera, p.settings);
  // The sun is at 45° over +x, so the shadow of the top reaches from x = -0.25 to x = -1.25.
  const double lit = luminance(pixel_at(picture, p.camera, {0.8f, 0, 0}));
  const double dark = luminance(pixel_at(picture, p.camera, {-0.8f, 0, 0}));
  const double beyond = luminance(pixel_at(picture, p.camera, {-1.5f, 0, 0}));
  EXPECT_LT(dark, 0.7 * lit);
  EXPECT_NEAR(beyond, lit, 0.05 * lit);
  EXPECT_NEAR(luminance(pixel_at(picture, p.camera, {-0.8f, 0, 0.6f})), lit, 0.05 * lit);  // next to it

  p.settings.lighting.towards_sun = {-1, 1, 0};
  const Picture other = draw(p.model, p.camera, p.settings);
  EXPECT_LT(luminance(pixel_at(other, p.camera, {0.8f, 0, 0})),
            0.7 * luminance(pixel_at(other, p.camera, {-0.8f, 0, 0})));

  p.settings.lighting.sun_shadow = false;
  const Picture without = draw(p.model, p.camera, p.settings);
  EXPECT_NEAR(luminance(pixel_at(without, p.camera, {0.8f, 0, 0})),
              luminance(pixel_at(without, p.camera, {-0.8f, 0, 0})), 0.01);
}

TEST_F(RendererTest, TheShadowEndsWhereGeometrySays) {
  Pillar p;
  p.settings.lighting.sun_softness = 1;
  const Picture picture = draw(p.model, p.camera, p.settings, 600, 600);
  const double lit = luminance(pixel_at(picture, p.camera, {1.2f, 0, 0})),
               dark = luminance(pixel_at(picture, p.camera, {-0.8f, 0, 0}));
  float edge = 0;
  for (float x = -0.8f; x > -1.8f; x -= 0.005f)
    if (luminance(pixel_at(picture, p.camera, {x, 0, 0})) > 0.5 * (lit + dark)) {
      edge = x;
      break;
    }
  EXPECT_NEAR(edge, -1.25, 0.03);
}

TEST_F(RendererTest, ThePlainSideTowardsTheSunIsBrighter) {
  Pillar p;
  p.settings.ground = Ground::kNone;
  CameraPlacement placement;
  placement.yaw = 45;
  placement.pitch = 0;
  const Camera camera = fit_camera({{0, 0.5f, 0}, 0.7f}, placement, 1);
  p.settings.lighting.towards_sun = {1, 0.2f, 0};
  const Picture picture = draw(p.model, camera, p.settings);
  EXPECT_GT(luminance(pixel_at(picture, camera, {0.25f, 0.5f, 0.05f})),
            1.5 * luminance(pixel_at(picture, camera, {0.05f, 0.5f, 0.25f})));
}

TEST_F(RendererTest, ClosedSurfacesDoNotShadowThemselvesWhereTheSunShines) {
  // Acne would darken some pixels of an evenly lit face.
  Model model;
  model.materials = {paint({0.5f, 0.5f, 0.5f})};
  add_box(model, {0, 0, 0}, glm::vec3(1));
  RenderSettings settings = bare();
  settings.lighting.towards_sun = {0.3f, 1, 0.2f};
  CameraPlacement placement;
  placement.pitch = 80;
  placement.yaw = 0;
  const Camera camera = fit_camera({{0, 0, 0}, 0.9f}, placement, 1);
  const Picture picture = draw(model, camera, settings);
  double lowest = 1, highest = 0;
  for (float x = -0.45f; x <= 0.45f; x += 0.02f)
    for (float z = -0.45f; z <= 0.45f; z += 0.02f) {
      const double y = luminance(pixel_at(picture, camera, {x, 0.5f, z}));
      lowest = std::min(lowest, y);
      highest = std::max(highest, y);
    }
  EXPECT_GT(lowest, 0.93 * highest);
}

TEST_F(RendererTest, TheSkyReachesCornersLessThanOpenGround) {
  Pillar p;
  p.settings.lighting.sun = glm::vec3(0);
  p.settings.lighting.sky_shadows = 32;
  const Picture picture = draw(p.model, p.camera, p.settings);
  const double close = luminance(pixel_at(picture, p.camera, {0, 0, 0.30f})),
               open = luminance(pixel_at(picture, p.camera, {0, 0, 1.4f}));
  EXPECT_LT(close, 0.85 * open);
  p.settings.lighting.sky_shadows = 0;
  const Picture without = draw(p.model, p.camera, p.settings);
  EXPECT_NEAR(luminance(pixel_at(without, p.camera, {0, 0, 0.30f})),
              luminance(pixel_at(without, p.camera, {0, 0, 1.4f})), 0.02);
}

/// Two squares facing +z: one at z = 0 that glows, one in front of it.
Model glow_behind(const Material& front) {
  Model model;
  Material glow = paint({0, 0, 0});
  glow.emissive = {0.5f, 0.5f, 0.5f};
  model.materials = {glow, front};
  add_box(model, {0, 0, -0.5f}, {2, 2, 0.1f}, 0);
  add_box(model, {0, 0, 0.5f}, {1, 1, 0.1f}, 1);
  return model;
}

TEST_F(RendererTest, AlphaBlendsInLinearLight) {
  Material veil = paint({0, 0, 0});
  veil.base_color.a = 0.5f;
  veil.alpha_mode = AlphaMode::kBlend;
  RenderSettings settings = bare();
  settings.lighting.sun = settings.lighting.sky = settings.lighting.ground = glm::vec3(0);
  CameraPlacement placement;
  placement.yaw = placement.pitch = 0;
  placement.orthographic = true;
  const Camera camera = fit_camera({{0, 0, 0}, 1.2f}, placement, 1);
  const Picture picture = draw(glow_behind(veil), camera, settings);
  const double open = luminance(pixel_at(picture, camera, {0.8f, 0.8f, 0.5f})),
               behind = luminance(pixel_at(picture, camera, {0, 0, 0.5f}));
  EXPECT_GT(open, 0.3);
  EXPECT_NEAR(behind, 0.25 * open, 0.02 * open);  // the light passes two faces: half of a half
}

TEST_F(RendererTest, ClearGlassLetsLightThroughAndTintsIt) {
  Material glass = paint({1, 1, 1});
  glass.roughness = 0.05f;
  glass.transmission = 1;
  RenderSettings settings = bare();
  settings.lighting.sun = settings.lighting.sky = settings.lighting.ground = glm::vec3(0);
  CameraPlacement placement;
  placement.yaw = placement.pitch = 0;
  placement.orthographic = true;
  const Camera camera = fit_camera({{0, 0, 0}, 1.2f}, placement, 1);
  const auto behind = [&](const Material& m, float x) {
    return pixel_at(draw(glow_behind(m), camera, settings), camera, {x, 0, 0.5f});
  };
  const double open = luminance(behind(glass, 0.9f));
  EXPECT_GT(luminance(behind(glass, 0)), 0.85 * open);  // 4 % are reflected at each of two faces
  EXPECT_LT(luminance(behind(glass, 0)), open + 0.2);
  glass.base_color = {1, 0.1f, 0.1f, 1};
  const Color red = behind(glass, 0);
  EXPECT_GT(linear(red[0]), 2 * linear(red[1]));
}

TEST_F(RendererTest, CutFacesAreOrangeWhenHighlighted) {
  Model model;
  model.materials = {paint({0.1f, 0.1f, 0.8f}), paint({0.1f, 0.8f, 0.1f})};
  model.materials[1].interior = true;
  add_box(model, {0, 0, 0}, glm::vec3(1), {1, 0, 0, 0, 0, 0});  // the face at +x is a cut
  sort_by_material(model);
  RenderSettings settings = bare();
  settings.highlight = Highlight::kInterior;
  settings.lighting.towards_sun = {1, 1, 1};
  CameraPlacement placement;
  placement.yaw = 45;
  placement.pitch = 0;
  placement.orthographic = true;
  placement.margin = 1;
  const Camera camera = fit_camera({{0, 0, 0}, std::sqrt(3.f) / 2}, placement, 1);
  const Picture picture = draw(model, camera, settings);
  double orange = 0, grey = 0;
  for (const Color& c : picture.pixels) {
    if (c[3] < 255) continue;
    (linear(c[0]) > 2 * linear(c[2]) ? orange : grey) += 1.0 / static_cast<double>(picture.pixels.size());
  }
  const double half = std::sqrt(2.0) / 2 / 3;  // each of two faces at 45°
  EXPECT_NEAR(orange, half, 0.02);
  EXPECT_NEAR(grey, half, 0.02);
}

TEST_F(RendererTest, FragmentColorsReplaceTheMaterial) {
  const Model model = cube_of_fragments(2);
  ViewOptions options;
  options.colors = Colors::kFragment;
  const auto states = view_states(model, options, {});
  CameraPlacement placement;
  placement.yaw = placement.pitch = 0;
  placement.orthographic = true;
  const Camera camera = fit_camera({{0, 0, 0}, 0.8f}, placement, 1);
  RenderSettings settings = bare();
  const Picture picture = draw(model, camera, settings, 300, 300, states);
  for (std::size_t k = 4; k < 8; ++k) {  // the four in front
    const glm::vec3 c = model.objects[k].fragment->centroid,
                    expected = distinct_color(static_cast<std::uint32_t>(k));
    const Color seen = pixel_at(picture, camera, {c.x, c.y, 0.5f});
    const glm::vec3 light(linear(seen[0]), linear(seen[1]), linear(seen[2]));
    // The hue is kept: channels that clearly differ keep their order.
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (expected[i] > expected[j] + 0.1f) {
          EXPECT_GT(light[i], light[j]) << "fragment " << k;
        }
  }
}

TEST_F(RendererTest, EveryLookDrawsAndNoTwoAreAlike) {
  Model model = cube_of_fragments(2);
  CameraPlacement placement;
  const Camera camera = fit_camera({{0, 0, 0}, 0.9f}, placement, 1);
  std::vector<Picture> pictures;
  for (std::size_t look = 1; look < kLookNames.size(); ++look) {
    RenderSettings settings;
    settings.look = *look_by_name(kLookNames[look]);
    pictures.push_back(draw(model, camera, settings, 128, 128));
    for (std::size_t other = 0; other + 1 < pictures.size(); ++other) {
      double difference = 0;
      for (std::size_t p = 0; p < pictures.back().pixels.size(); ++p)
        difference += std::abs(luminance(pictures.back().pixels[p]) - luminance(pictures[other].pixels[p]));
      EXPECT_GT(difference, 20) << kLookNames[look] << " and " << kLookNames[other + 1];
    }
  }
  EXPECT_FALSE(look_by_name("cheese"));
}

}  // namespace
}  // namespace fracture::test
