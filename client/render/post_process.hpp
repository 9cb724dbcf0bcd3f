// Turns light into colours: resolves each pixel's samples, adds bloom to bright spots, applies exposure and
// tone mapping, and smooths edges that multisampling misses.
#pragma once

#include "client/render/high_targets.hpp"

namespace fracture::render {

class PostProcess {
 public:
  /// kGraphicsDriver if a shader is rejected.
  static Expected<PostProcess> create();
  /// From targets.light into all of `framebuffer`, which takes linear light as sRGB. The frame block must be
  /// bound. Returns the number of draw calls.
  std::size_t draw(const HighTargets& targets, GLuint framebuffer) const;

 private:
  PostProcess() = default;
  Program resolve_, down_, up_, finish_, antialias_;
  VertexArray empty_;
};

}  // namespace fracture::render
