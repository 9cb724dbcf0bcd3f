#include "client/render/high_targets.hpp"

#include <algorithm>
#include <string>

namespace fracture::render {
namespace {

struct Format {
  GLenum internal, external, type;
  bool depth = false, linear = true, levels = false;
};

constexpr Format kLight{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT};
constexpr Format kLightWithLevels{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, false, true, true};
constexpr Format kPlaces{GL_RGBA32F, GL_RGBA, GL_FLOAT, false, false};  // millimetre precision at a distance
constexpr Format kShare{GL_R8, GL_RED, GL_UNSIGNED_BYTE, false, false};
constexpr Format kColors{GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE};
constexpr Format kDepth{GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, true, false};

Layer make_layer(int width, int height, const Format& format) {
  Layer layer;
  layer.width = width;
  layer.height = height;
  layer.texture = make_texture();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, layer.texture.get());
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format.internal), width, height, 0, format.external,
               format.type, nullptr);
  const GLint filter = format.linear ? GL_LINEAR : GL_NEAREST;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, format.levels ? GL_LINEAR_MIPMAP_LINEAR : filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  layer.framebuffer = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, layer.framebuffer.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, format.depth ? GL_DEPTH_ATTACHMENT : GL_COLOR_ATTACHMENT0,
                         GL_TEXTURE_2D, layer.texture.get(), 0);
  if (format.depth) {
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
  }
  return layer;
}

bool complete(const Framebuffer& framebuffer) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.get());
  return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

}  // namespace

void Layer::begin() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.get());
  glViewport(0, 0, width, height);
}

Expected<HighTargets> HighTargets::create(int width, int height) {
  constexpr int kSamples = 4, kBloomLevels = 6, kSmallest = 4;
  HighTargets t;
  t.width = width;
  t.height = height;
  GLint most = 1, most_depth = 1;
  glGetIntegerv(GL_MAX_COLOR_TEXTURE_SAMPLES, &most);
  glGetIntegerv(GL_MAX_SAMPLES, &most_depth);
  t.samples = std::clamp(std::min(most, most_depth), 1, kSamples);
  t.light = make_texture();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, t.light.get());
  glTexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, t.samples, GL_RGBA16F, width, height, GL_TRUE);
  t.light_depth = make_renderbuffer();
  glBindRenderbuffer(GL_RENDERBUFFER, t.light_depth.get());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, t.samples, GL_DEPTH_COMPONENT24, width, height);
  t.lit = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, t.lit.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D_MULTISAMPLE, t.light.get(), 0);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, t.light_depth.get());
  t.scene_depth = make_layer(width, height, kDepth);
  t.raw_occlusion = make_layer(width, height, kShare);
  t.occlusion = make_layer(width, height, kShare);
  t.glass_front = make_layer(width, height, kDepth);
  t.glass_back = make_layer(width, height, kPlaces);
  t.glass_depth = make_renderbuffer();
  glBindRenderbuffer(GL_RENDERBUFFER, t.glass_depth.get());
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, t.glass_depth.get());
  t.behind = make_layer(width, height, kLightWithLevels);
  t.shown = make_layer(width, height, kColors);
  bool good = complete(t.lit);
  for (const Layer* layer :
       {&t.scene_depth, &t.raw_occlusion, &t.occlusion, &t.glass_front, &t.glass_back, &t.behind, &t.shown})
    good = good && complete(layer->framebuffer);
  for (int k = 1; k <= kBloomLevels; ++k) {
    const int w = width >> k, h = height >> k;
    if (k > 1 && std::min(w, h) < kSmallest) break;
    t.bloom.push_back(make_layer(std::max(1, w), std::max(1, h), kLight));
    good = good && complete(t.bloom.back().framebuffer);
  }
  if (!good)
    return fail(ErrorCode::kGraphicsDriver, "The driver refuses the framebuffers of a picture of " +
                                                std::to_string(width) + " x " + std::to_string(height) +
                                                " pixels in the high tier.");
  return t;
}

}  // namespace fracture::render
