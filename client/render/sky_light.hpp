// The sky as a cube map for mirroring surfaces: level k is for roughness k / 5. It is drawn once, and again
// when the colours of sun, sky or ground change.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "client/render/frame_block.hpp"

namespace fracture::render {

class SkyLight {
 public:
  /// kGraphicsDriver if a shader or the cube map is rejected.
  static Expected<SkyLight> create();
  /// Draws the map if it is out of date; the frame block must be bound. Leaves the map at its texture unit.
  void update(const FrameBlock& frame);

 private:
  SkyLight() = default;
  void draw_face(GLuint cube, int face, int level, int side) const;
  Program source_program_, blur_program_;
  Texture source_, blurred_;
  Framebuffer framebuffer_;
  VertexArray empty_;
  std::optional<std::array<glm::vec4, 4>> drawn_;  ///< the inputs it was drawn with
};

}  // namespace fracture::render
