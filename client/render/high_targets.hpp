// What the high tier draws into before there are colours: light in half floats with as many samples as the driver has up to
// four, and layers of the picture that later passes read.
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
  /// kGraphicsDriver where the driver refuses one of them.
  static Expected<HighTargets> create(int width, int height);

  int width = 0, height = 0, samples = 0;
  Texture light;  ///< multisampled
  Renderbuffer light_depth, glass_depth;
  Framebuffer lit;
  Layer scene_depth;               ///< of what is opaque, one sample
  Layer raw_occlusion, occlusion;  ///< 1: open
  Layer glass_front, glass_back;   ///< depth; normal and distance
  Layer behind;                    ///< one sample of `light`, with levels
  Layer shown;                     ///< colours, before edges are smoothed
  std::vector<Layer> bloom;        ///< each half as large as the one before it
};

}  // namespace fracture::render
