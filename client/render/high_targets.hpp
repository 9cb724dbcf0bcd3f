// The high tier's targets before tone mapping: light in half floats, with up to four samples if the driver
// has them, and layers of the picture that later passes read.
#pragma once

#include <vector>

#include "client/render/gl_objects.hpp"

namespace fracture::render {

/// A texture that can be drawn into.
struct Layer {
  Texture texture;
  Framebuffer framebuffer;
  int width = 0, height = 0;
  void begin() const;  ///< binds the framebuffer and sets the viewport
};

struct HighTargets {
  /// kGraphicsDriver if the driver rejects one of them.
  static Expected<HighTargets> create(int width, int height);

  int width = 0, height = 0, samples = 0;
  Texture light;  ///< multisampled
  Renderbuffer light_depth, glass_depth;
  Framebuffer lit;
  Layer scene_depth;               ///< of opaque surfaces, one sample
  Layer raw_occlusion, occlusion;  ///< 1: not occluded
  Layer glass_front, glass_back;   ///< depth of front faces; normal and distance of back faces
  Layer behind;                    ///< one sample per pixel of `light`, with mipmap levels
  Layer shown;                     ///< colours before antialiasing
  std::vector<Layer> bloom;        ///< each half as large as the previous one
};

}  // namespace fracture::render
