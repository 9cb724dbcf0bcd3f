// Draws a picture in the high tier, after the depths of sun and sky. The order is: depth of opaque surfaces,
// ambient occlusion, sky, opaque surfaces, ground, hidden glass, and then the nearest glass, which refracts
// everything behind it. The overlay, bloom, exposure, tone mapping and antialiasing follow. Light stays
// linear until tone mapping.
#pragma once

#include <memory>
#include <optional>

#include "client/render/frame_block.hpp"
#include "client/render/high_targets.hpp"
#include "client/render/occlusion.hpp"
#include "client/render/post_process.hpp"
#include "client/render/sky_light.hpp"

namespace fracture::render {

class HighPicture {
 public:
  /// kGraphicsDriver if a shader is rejected.
  static Expected<std::unique_ptr<HighPicture>> create();

  /// Prepares for pictures of this size. kGraphicsDriver if a framebuffer is rejected.
  Expected<void> prepare(int width, int height);

  struct Shown {
    std::span<const DrawItem> items;
    const Camera& camera;
    const RenderSettings& settings;
    const FrameBlock& frame;  ///< as uploaded
  };
  /// Draws in the prepared size. Frame block, object tables and shadow maps must be bound.
  void draw(const Shown& shown, GLuint framebuffer, FrameStats& stats);

 private:
  HighPicture(SkyLight sky, Occlusion occlusion, PostProcess post)
      : sky_(std::move(sky)), occlusion_(std::move(occlusion)), post_(std::move(post)) {}
  void draw_depth(const Shown& shown, FrameStats& stats) const;
  void draw_ground(const Program& program, const Shown& shown) const;
  void draw_opaque(const Shown& shown, FrameStats& stats) const;
  void draw_glass(const Shown& shown, FrameStats& stats) const;

  SkyLight sky_;
  Occlusion occlusion_;
  PostProcess post_;
  Program surface_, depth_, ground_, ground_depth_, background_, glass_back_;
  VertexArray empty_;
  std::optional<HighTargets> targets_;
};

}  // namespace fracture::render
