// A multisampled picture to draw into, and its way back to memory. A window has its own framebuffer instead.
#pragma once

#include "client/render/gl_objects.hpp"
#include "client/render/image.hpp"

namespace fracture::render {

class FrameTarget {
 public:
  /// Colour in sRGB with alpha, 24-bit depth; as many samples as are asked for and the driver has (llvmpipe:
  /// 4). kTooLarge over the driver's renderbuffers, kGl where it is refused.
  static Expected<FrameTarget> create(int width, int height, int samples = 4);

  int width() const { return width_; }
  int height() const { return height_; }
  GLuint framebuffer() const { return multisampled_.get(); }
  /// Resolves and copies; alpha is the share of each pixel that something covers. Waits for the driver.
  Picture read() const;
  /// Resolves and copies to the lower left corner of another framebuffer of the same encoding (a window's),
  /// as the bytes are.
  void copy_to(GLuint framebuffer) const;

 private:
  FrameTarget() = default;
  void resolve() const;  ///< leaves the result bound for reading
  int width_ = 0, height_ = 0;
  Framebuffer multisampled_, resolved_;
  Renderbuffer color_, depth_, resolved_color_;
};

}  // namespace fracture::render
