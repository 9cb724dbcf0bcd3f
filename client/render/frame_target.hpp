// A multisampled picture to draw into, which can be read back to memory. A window has its own framebuffer.
#pragma once

#include "client/render/gl_objects.hpp"
#include "client/render/image.hpp"

namespace fracture::render {

class FrameTarget {
 public:
  /// Colour in sRGB with alpha, 24-bit depth. Uses as many of the requested samples as the driver supports
  /// (llvmpipe: 4). kTooLarge beyond the driver's limit for renderbuffers, kGraphicsDriver if the driver
  /// refuses.
  static Expected<FrameTarget> create(int width, int height, int samples = 4);

  int width() const { return width_; }
  int height() const { return height_; }
  GLuint framebuffer() const { return multisampled_.get(); }
  /// Resolves and copies. Alpha is the covered share of each pixel. Waits for the driver.
  Picture read() const;
  /// Resolves and copies the bytes unchanged to the lower left corner of another framebuffer with the same
  /// encoding (a window's).
  void copy_to(GLuint framebuffer) const;

 private:
  FrameTarget() = default;
  void resolve() const;  ///< leaves the result bound for reading
  int width_ = 0, height_ = 0;
  Framebuffer multisampled_, resolved_;
  Renderbuffer color_, depth_, resolved_color_;
};

}  // namespace fracture::render
