#include "client/render/camera.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace fracture::render {

glm::vec3 direction_to_camera(const CameraPlacement& placement) {
  const float yaw = glm::radians(placement.yaw),
              pitch = glm::radians(std::clamp(placement.pitch, -89.f, 89.f));
  return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
}

Camera fit_camera(const Sphere& sphere, const CameraPlacement& placement, float aspect) {
  const float radius = placement.margin * (sphere.radius > 0 ? sphere.radius : 1.f);
  const glm::vec3 target = placement.target.value_or(sphere.center), towards = direction_to_camera(placement);
  const float wide = std::max(aspect, 1.f), high = std::max(1 / aspect, 1.f);
  Camera camera;
  if (placement.orthographic) {
    camera.eye = target + 2 * radius * towards;
    camera.projection =
        glm::ortho(-radius * wide, radius * wide, -radius * high, radius * high, 0.01f * radius, 40 * radius);
  } else {
    const float half = glm::radians(std::clamp(placement.field_of_view, 1.f, 120.f)) / 2;
    const float distance = radius / std::sin(half);
    camera.eye = target + distance * towards;
    const float near = std::max(0.02f * distance, 0.8f * (distance - radius)), edge = near * std::tan(half);
    camera.projection =
        glm::frustum(-edge * wide, edge * wide, -edge * high, edge * high, near, distance + 40 * radius);
  }
  camera.view = glm::lookAt(camera.eye, target, glm::vec3(0, 1, 0));
  return camera;
}

std::array<glm::vec4, 6> frustum_planes(const glm::mat4& m) {
  const auto row = [&](int r) { return glm::vec4(m[0][r], m[1][r], m[2][r], m[3][r]); };
  std::array<glm::vec4, 6> planes;
  for (int axis = 0; axis < 3; ++axis) {
    planes[static_cast<std::size_t>(2 * axis)] = row(3) + row(axis);
    planes[static_cast<std::size_t>(2 * axis + 1)] = row(3) - row(axis);
  }
  for (glm::vec4& plane : planes) plane /= glm::length(glm::vec3(plane));
  return planes;
}

bool touches(const std::array<glm::vec4, 6>& planes, const Sphere& sphere) {
  return std::all_of(planes.begin(), planes.end(), [&](const glm::vec4& plane) {
    return glm::dot(glm::vec3(plane), sphere.center) + plane.w >= -sphere.radius;
  });
}

}  // namespace fracture::render
