// Draws debris over a picture of the scene with OpenGL 3.3 core. Surfaces get marks, and crumbs get light and
// shadow. Dust is more transparent near surfaces.
#pragma once

#include <span>

#include "client/effects/debris.hpp"
#include "client/render/camera.hpp"
#include "client/render/gl_objects.hpp"
#include "client/render/tier.hpp"

namespace fracture::effects {

/// A mark in world coordinates.
struct PlacedMark {
  const Mark* mark;
  glm::vec3 position, normal;
};

class DebrisView {
 public:
  /// For pictures in this tier. kGraphicsDriver if the driver rejects a shader.
  static Expected<DebrisView> create(render::Tier tier = render::Tier::kLow);

  /// Draws into `framebuffer`, as the overlay of Renderer::draw or right after it (low tier). The renderer's
  /// frame block and shadow maps must still be bound. Returns the number of draw calls: 0 without debris.
  std::size_t draw(const Debris& debris, std::span<const PlacedMark> marks, const render::Camera& camera,
                   GLuint framebuffer, int width, int height);

 private:
  DebrisView() = default;
  Expected<void> build_programs(render::Tier tier);
  void make_puff_shapes();
  void make_boxes();
  void copy_depth(GLuint framebuffer, int width, int height);
  void draw_crumbs(const std::vector<Crumb>& crumbs);
  void draw_marks(std::span<const PlacedMark> marks);
  void draw_puffs(const std::vector<Puff>& puffs, const render::Camera& camera);

  render::Program puff_, crumb_, mark_;
  render::VertexArray puffs_, crumbs_, marks_;
  render::Buffer puff_buffer_, crumb_buffer_, mark_buffer_, crumb_shape_, box_;
  render::Texture shapes_, depth_;
  render::Framebuffer depth_framebuffer_;
  int width_ = 0, height_ = 0;  ///< size of the copied depth
  std::vector<float> data_;
};

}  // namespace fracture::effects
