#include "client/render/frame_target.hpp"

#include <algorithm>
#include <string>

namespace fracture::render {

Expected<FrameTarget> FrameTarget::create(int width, int height, int samples) {
  GLint largest = 0, most_samples = 0;
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
  glGetIntegerv(GL_MAX_SAMPLES, &most_samples);
  if (width < 1 || height < 1 || width > largest || height > largest)
    return fail(ErrorCode::kTooLarge, "A picture of " + std::to_string(width) + " x " +
                                          std::to_string(height) +
                                          " pixels cannot be drawn; this driver supports sides of 1 to " +
                                          std::to_string(largest) + ".");
  FrameTarget target;
  target.width_ = width;
  target.height_ = height;
  const auto storage = [&](GLsizei count, GLenum format) {
    Renderbuffer buffer = make_renderbuffer();
    glBindRenderbuffer(GL_RENDERBUFFER, buffer.get());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, count, format, width, height);
    return buffer;
  };
  const GLsizei count = std::clamp(samples, 0, most_samples);
  target.color_ = storage(count, GL_SRGB8_ALPHA8);
  target.depth_ = storage(count, GL_DEPTH_COMPONENT24);
  target.resolved_color_ = storage(0, GL_SRGB8_ALPHA8);
  target.multisampled_ = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, target.multisampled_.get());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target.color_.get());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, target.depth_.get());
  const GLenum first = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  target.resolved_ = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, target.resolved_.get());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                            target.resolved_color_.get());
  const GLenum second = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (first != GL_FRAMEBUFFER_COMPLETE || second != GL_FRAMEBUFFER_COMPLETE)
    return fail(ErrorCode::kGraphicsDriver, "The driver refuses a framebuffer of " + std::to_string(width) +
                                                " x " + std::to_string(height) + " pixels (status " +
                                                std::to_string(first) + ", " + std::to_string(second) + ").");
  return target;
}

void FrameTarget::resolve() const {
  glEnable(GL_FRAMEBUFFER_SRGB);  // samples are averaged in linear light
  glBindFramebuffer(GL_READ_FRAMEBUFFER, multisampled_.get());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.get());
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.get());
}

Picture FrameTarget::read() const {
  resolve();
  Picture flipped(width_, height_), picture(width_, height_);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, flipped.pixels.data());
  for (int y = 0; y < height_; ++y)  // OpenGL counts rows from the bottom
    std::copy_n(&flipped.at(0, height_ - 1 - y), width_, &picture.at(0, y));
  return picture;
}

void FrameTarget::copy_to(GLuint framebuffer) const {
  resolve();
  glDisable(GL_FRAMEBUFFER_SRGB);  // copies the bytes unchanged
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
}

}  // namespace fracture::render
