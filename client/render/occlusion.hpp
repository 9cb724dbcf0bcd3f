// Ambient occlusion from the picture's depth (shaders/occlusion_fragment.glsl names the paper).
#pragma once

#include "client/render/camera.hpp"
#include "client/render/high_targets.hpp"

namespace fracture::render {

class Occlusion {
 public:
  /// kGraphicsDriver if a shader is rejected.
  static Expected<Occlusion> create();
  /// Computes targets.occlusion from targets.scene_depth, and leaves both at their texture units. The frame
  /// block must be bound.
  void draw(const HighTargets& targets, const Camera& camera) const;

 private:
  Occlusion() = default;
  Program raw_, blur_;
  VertexArray empty_;
};

}  // namespace fracture::render
