// From light to colours: the samples of each pixel become one, what is bright blooms, exposure and tone mapping, and edges
// that samples do not see are smoothed.
#pragma once

#include "client/render/high_targets.hpp"

namespace fracture::render {

class PostProcess {
 public:
  /// kGraphicsDriver where a shader is refused.
  static Expected<PostProcess> create();
  /// From targets.light into `framebuffer`, all of its width and height; it takes linear light as sRGB. The frame block has to
  /// be bound. Returns the number of draw calls.
  std::size_t draw(const HighTargets& targets, GLuint framebuffer) const;

 private:
  PostProcess() = default;
  Program resolve_, down_, up_, finish_, antialias_;
  VertexArray empty_;
};

}  // namespace fracture::render
