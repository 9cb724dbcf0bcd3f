// The data of the current picture that every program gets: the uniform block of shaders/frame.glsl.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "client/render/renderer.hpp"
#include "client/render/shadow_maps.hpp"

namespace fracture::render {

/// Laid out for std140: only matrices and four-component vectors.
struct FrameBlock {
  glm::mat4 view_projection, inverse_view_projection, sun_matrix;
  glm::mat4 sky_matrix[kMaxSkyDirections];
  glm::vec4 sky_direction[kMaxSkyDirections];
  glm::vec4 eye;          ///< w: exposure
  glm::vec4 towards_sun;  ///< w: softness in texels
  glm::vec4 sun;          ///< w: 1 with shadow
  glm::vec4 sky, ground;  ///< sky.w: number of directions; ground.w: 1 if the camera is orthographic
  glm::vec4 background_top, background_bottom;
  glm::vec4 sphere;   ///< around the drawn objects: centre, radius
  glm::vec4 plane;    ///< of the ground: rgb colour, w: height
  glm::vec4 texel;    ///< metres per texel: sun, sky; then 1 / side: sun, sky
  glm::vec4 forward;  ///< the camera's direction, for orthographic ones
  glm::vec4 fog;      ///< high tier: 1 / metres to fog; occlusion radius in metres; 1 / pixels
};

FrameBlock frame_block(std::span<const DrawItem> items, const Camera& camera, const RenderSettings& settings,
                       const ShadowMaps& shadows, int width, int height);

/// A sphere in a model's frame, transformed to the world.
Sphere in_world(const Sphere& local, const glm::mat4& transform);

}  // namespace fracture::render
