// A context and a renderer for all tests of a suite, or the reason why there is none. Also functions that
// measure pictures.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "client/egl/egl_context.hpp"
#include "client/render/frame_target.hpp"
#include "client/render/renderer.hpp"
#include "tests/client/models.hpp"

namespace fracture::test {

class RendererTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto made = egl::EglContext::create();
    if (!made) {
      reason = made.error().detail;
      return;
    }
    context = std::make_unique<egl::EglContext>(std::move(*made));
    auto built = render::Renderer::create();
    ASSERT_TRUE(built) << built.error().detail;
    renderer = std::make_unique<render::Renderer>(std::move(*built));
  }
  static void TearDownTestSuite() {
    renderer.reset();
    context.reset();
  }
  void SetUp() override {
    if (!context) GTEST_SKIP() << reason;
    ASSERT_TRUE(renderer);
  }

  /// Draws once; the statistics are in `stats`.
  render::Picture draw(const render::Model& model, const render::Camera& camera,
                       const render::RenderSettings& settings, int width = 300, int height = 300,
                       std::span<const render::ObjectState> states = {}) {
    auto gpu = render::GpuModel::upload(std::make_shared<const render::Model>(model));
    if (!gpu) throw std::runtime_error(gpu.error().detail);
    auto target = render::FrameTarget::create(width, height);
    if (!target) throw std::runtime_error(target.error().detail);
    const auto initial = initial_states(model);
    stats = renderer->draw(*gpu, states.empty() ? std::span<const render::ObjectState>(initial) : states,
                           camera, settings, target->framebuffer(), width, height);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target->read();
  }

  /// Settings that draw only the objects, on transparent black.
  static render::RenderSettings bare() {
    render::RenderSettings settings;
    settings.ground = render::Ground::kNone;
    settings.background = false;
    settings.lighting.sky_shadows = 0;  // tests that judge these set them
    return settings;
  }

  render::FrameStats stats;
  static inline std::unique_ptr<egl::EglContext> context;
  static inline std::unique_ptr<render::Renderer> renderer;
  static inline std::string reason;
};

/// The share of the picture that something covers, by its alpha.
inline double coverage(const render::Picture& picture) {
  double sum = 0;
  for (const render::Color& c : picture.pixels) sum += c[3] / 255.0;
  return sum / static_cast<double>(picture.pixels.size());
}

/// Linear light of a channel (IEC 61966-2-1).
inline double linear(std::uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

inline double luminance(const render::Color& c) {
  return 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
}

/// The pixel that shows a point in the world.
inline render::Color pixel_at(const render::Picture& picture, const render::Camera& camera,
                              const glm::vec3& point) {
  const glm::vec4 clip = camera.view_projection() * glm::vec4(point, 1);
  const int x =
      static_cast<int>(std::floor((0.5f + 0.5f * clip.x / clip.w) * static_cast<float>(picture.width)));
  const int y =
      static_cast<int>(std::floor((0.5f - 0.5f * clip.y / clip.w) * static_cast<float>(picture.height)));
  EXPECT_TRUE(x >= 0 && y >= 0 && x < picture.width && y < picture.height) << x << ", " << y;
  return picture.at(x, y);
}

/// The unit cube around the origin.
inline render::Model red_cube() {
  render::Model model;
  model.materials.push_back(paint({0.8f, 0.02f, 0.02f}));
  add_box(model, {0, 0, 0}, {1, 1, 1});
  return model;
}

/// A camera that looks at the sphere from a direction in degrees, and shows exactly the sphere.
inline render::Camera straight(float yaw, float pitch, bool orthographic = true,
                               render::Sphere sphere = {{0, 0, 0}, std::sqrt(3.f) / 2}) {
  render::CameraPlacement placement;
  placement.yaw = yaw;
  placement.pitch = pitch;
  placement.orthographic = orthographic;
  placement.margin = 1;
  return render::fit_camera(sphere, placement, 1);
}

}  // namespace fracture::test
