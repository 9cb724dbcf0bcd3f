#include "client/render/frame_block.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fracture::render {
namespace {

float largest_scale(const glm::mat4& m) {
  return std::sqrt(std::max({glm::dot(m[0], m[0]), glm::dot(m[1], m[1]), glm::dot(m[2], m[2])}));
}

/// A sphere around the bounding spheres of the visible objects. This is cheap enough for every frame, unlike
/// one around vertices.
Sphere around_objects(std::span<const DrawItem> items) {
  glm::vec3 low(HUGE_VALF), high(-HUGE_VALF);
  const auto each = [&](auto&& use) {
    for (const DrawItem& item : items)
      for (std::size_t k = 0; k < item.states.size(); ++k)
        if (item.states[k].visible)
          use(in_world(item.model->model().objects[k].bounds, item.states[k].transform));
  };
  each([&](const Sphere& s) {
    low = glm::min(low, s.center - s.radius);
    high = glm::max(high, s.center + s.radius);
  });
  if (!(low.x <= high.x)) return {{0, 0, 0}, 1};
  Sphere result{0.5f * (low + high), 0};
  each([&](const Sphere& s) {
    result.radius = std::max(result.radius, glm::distance(s.center, result.center) + s.radius);
  });
  result.radius = std::max(result.radius, 1e-6f);
  return result;
}

float lowest_point(std::span<const DrawItem> items) {
  float lowest = HUGE_VALF;
  for (const DrawItem& item : items)
    for (const Vertex& v : item.model->model().vertices)
      if (item.states[v.object].visible) {
        const glm::mat4& m = item.states[v.object].transform;
        lowest =
            std::min(lowest, m[0].y * v.position.x + m[1].y * v.position.y + m[2].y * v.position.z + m[3].y);
      }
  return std::isfinite(lowest) ? lowest : 0.f;
}

/// Distance of the far plane from the eye, in metres.
float far_plane(const Camera& camera) {
  const glm::mat4& p = camera.projection;
  return p[3][3] == 1.f ? (p[3][2] - 1) / p[2][2] : p[3][2] / (p[2][2] + 1);
}

}  // namespace

Sphere in_world(const Sphere& local, const glm::mat4& transform) {
  return {glm::vec3(transform * glm::vec4(local.center, 1)), local.radius * largest_scale(transform)};
}

FrameBlock frame_block(std::span<const DrawItem> items, const Camera& camera, const RenderSettings& settings,
                       const ShadowMaps& shadows, int width, int height) {
  const Lighting& light = settings.lighting;
  const Sphere sphere = settings.lit ? *settings.lit : around_objects(items);
  FrameBlock frame{};
  frame.view_projection = camera.view_projection();
  frame.inverse_view_projection = glm::inverse(frame.view_projection);
  const glm::vec3 towards_sun = glm::dot(light.towards_sun, light.towards_sun) > 0
                                    ? glm::normalize(light.towards_sun)
                                    : glm::vec3(0, 1, 0);
  frame.sun_matrix = light_matrix(sphere, towards_sun);
  const int sky_count = std::clamp(light.sky_shadows, 0, shadows.sky_count());
  const std::vector<glm::vec3> directions = sky_directions(sky_count);
  for (std::size_t k = 0; k < directions.size(); ++k) {
    frame.sky_matrix[k] = light_matrix(sphere, directions[k]);
    frame.sky_direction[k] = glm::vec4(directions[k], 0);
  }
  const bool orthographic = camera.projection[3][3] == 1.f;
  frame.eye = glm::vec4(camera.eye, light.exposure);
  frame.towards_sun = glm::vec4(towards_sun, light.sun_softness);
  frame.sun = glm::vec4(light.sun, light.sun_shadow ? 1 : 0);
  frame.sky = glm::vec4(light.sky, static_cast<float>(sky_count));
  frame.ground = glm::vec4(light.ground, orthographic ? 1 : 0);
  frame.background_top = glm::vec4(settings.background_top, 1);
  frame.background_bottom = glm::vec4(settings.background_bottom, 1);
  frame.sphere = glm::vec4(sphere.center, sphere.radius);
  const float height_of_ground = settings.ground_height.value_or(
      settings.ground == Ground::kNone ? 0.f : lowest_point(items) - 1e-3f * sphere.radius);
  frame.plane = glm::vec4(settings.ground_color, height_of_ground);
  frame.texel =
      glm::vec4(2 * sphere.radius / static_cast<float>(shadows.sun_side()),
                2 * sphere.radius / static_cast<float>(shadows.sky_side()),
                1.f / static_cast<float>(shadows.sun_side()), 1.f / static_cast<float>(shadows.sky_side()));
  frame.forward = glm::vec4(-camera.view[0][2], -camera.view[1][2], -camera.view[2][2], 0);
  // Fog starts beyond the objects, and hides everything before the far plane cuts the ground off.
  constexpr float kClearRadii = 10, kFogsToFarPlane = 2.4f, kOcclusionRadii = 0.12f;
  frame.fog = glm::vec4(
      1 / std::max(1e-6f, std::min(kClearRadii * sphere.radius, far_plane(camera) / kFogsToFarPlane)),
      kOcclusionRadii * sphere.radius, 1.f / static_cast<float>(width), 1.f / static_cast<float>(height));
  return frame;
}

}  // namespace fracture::render
