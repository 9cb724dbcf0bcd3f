// The sky as a cube of textures for what mirrors it: level k is for roughness k / 5. Drawn once, and again when sun, sky or
// ground have other colours.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "client/render/frame_block.hpp"

namespace fracture::render {

class SkyLight {
 public:
  /// kGraphicsDriver where a shader or the cube is refused.
  static Expected<SkyLight> create();
  /// Draws what is not there yet; the frame block has to be bound. Leaves the cube at its texture unit.
  void update(const FrameBlock& frame);

 private:
  SkyLight() = default;
  void draw_face(GLuint cube, int face, int level, int side) const;
  Program source_program_, blur_program_;
  Texture source_, blurred_;
  Framebuffer framebuffer_;
  VertexArray empty_;
  std::optional<std::array<glm::vec4, 4>> drawn_;  ///< what it depends on
};

}  // namespace fracture::render
