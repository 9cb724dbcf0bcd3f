// The high tier of a picture, after the depths of sun and sky: depth of what is opaque → ambient occlusion from it →
// sky, opaque surfaces, ground → what glass hides of other glass → the nearest glass, which bends what is behind it →
// overlay → bloom, exposure, tone mapping, edges. Light is linear until the end.
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
  /// kGraphicsDriver where a shader is refused.
  static Expected<std::unique_ptr<HighPicture>> create();

  /// For pictures of a size. kGraphicsDriver where a framebuffer is refused.
  Expected<void> prepare(int width, int height);

  struct Shown {
    std::span<const DrawItem> items;
    const Camera& camera;
    const RenderSettings& settings;
    const FrameBlock& frame;  ///< as uploaded
  };
  /// Of the size that was prepared. Frame block, object tables and shadow maps have to be bound.
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
