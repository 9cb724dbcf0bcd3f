// The camera of a picture. Deterministic: the same sphere and angles give the same matrices.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "client/render/model.hpp"

namespace fracture::render {

struct Camera {
  glm::mat4 view{1}, projection{1};  ///< for OpenGL's clip space: z from -1 to 1
  glm::vec3 eye{};
  glm::mat4 view_projection() const { return projection * view; }
};

struct CameraPlacement {
  float yaw = 35;                     ///< degrees around y; 0 looks along -z, 90 along -x
  float pitch = 18;                   ///< degrees above the horizon, -89 … 89
  float field_of_view = 30;           ///< degrees of the shorter side, 1 … 120; ignored if orthographic
  float margin = 1.04f;               ///< relative to the sphere's radius
  bool orthographic = false;          ///< the shorter side then shows margin × the diameter
  std::optional<glm::vec3> target{};  ///< centre of the picture; empty: the centre of the sphere
};

/// Looks at the target from a distance at which a sphere of that radius around it fits. A radius of 0 counts
/// as 1.
Camera fit_camera(const Sphere& sphere, const CameraPlacement& placement, float aspect);

/// Direction from the target to the camera, unit length.
glm::vec3 direction_to_camera(const CameraPlacement& placement);

/// Left, right, bottom, top, near, far: ax + by + cz + d >= 0 inside, (a, b, c) of unit length. Gribb &
/// Hartmann, "Fast Extraction of Viewing Frustum Planes from the World-View-Projection Matrix", 2001.
std::array<glm::vec4, 6> frustum_planes(const glm::mat4& view_projection);

/// Whether a part of the sphere may be inside.
bool touches(const std::array<glm::vec4, 6>& planes, const Sphere& sphere);

}  // namespace fracture::render
